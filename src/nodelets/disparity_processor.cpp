#include "nodelets/disparity_processor.h"

#include <sensor_msgs/image_encodings.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <string>
#include <type_traits>

#include "predictive_stereo/simd_target.h"

namespace predictive_stereo {
namespace {

// Resolution of the sub-pixel interpolation: costs are integers of at most a few hundred.
constexpr float kDisparityStep = 1.0f / 16;

// See DisparityMessages::contradicted_fraction; 0 if only a few pixels are predicted.
double contradictedFraction(const cv::Mat1f& predicted_px, const cv::Mat1f& measured_px,
                            float min_disparity_px) {
  constexpr int kStep = 2;  // a quarter of the pixels is enough for a share
  constexpr int kFewest = 300;
  int both = 0, contradicted = 0;
  for (int y = 0; y < predicted_px.rows; y += kStep)
    for (int x = 0; x < predicted_px.cols; x += kStep) {
      const float predicted = predicted_px(y, x), measured = measured_px(y, x);
      if (predicted < min_disparity_px || measured < min_disparity_px) continue;
      ++both;
      contradicted += std::abs(predicted - measured) > std::max(3.f, 0.05f * measured);
    }
  return both < kFewest ? 0 : static_cast<double>(contradicted) / both;
}

}  // namespace

DisparityProcessor::DisparityProcessor(const DisparityNodeletParams& params)
    : loop_(params.disparity, params.max_gap) {
  validate(params);
}

std::string DisparityProcessor::slowTargetWarning() const {
  return predictive_stereo::slowTargetWarning(loop_.params().matcher.simd_target, simdTarget());
}

SequenceGuard::Result DisparityProcessor::begin(const StereoPair& pair) {
  const StereoFrame frame = stereoFrame(pair, left_buffer_, right_buffer_);
  const SequenceGuard::Result sequence = loop_.begin(frame);
  if (sequence.isIgnored()) return sequence;
  pair_ = pair;
  rig_ = frame.rig;
  return sequence;
}

DisparityMessages DisparityProcessor::process(const Sources& sources) {
  DisparityMessages result = allocate();
  loop_.setColumnOffset(sources.column_offset);
  const auto unknown = [](const Past&) { return std::nullopt; };
  loop_.measure(sources.motion ? sources.motion : unknown, sources.moved, maps_);
  result.row_alignment =
      rowAlignmentMsg(maps_.row_alignment, loop_.columnOffset(), pair_.left->header);
  if (sources.measured) sources.measured(result);
  loop_.publish(maps_);

  result.predicted = maps_.predicted;
  result.contradicted_fraction =
      contradictedFraction(maps_.predicted_disparity_px, maps_.measured_disparity_px,
                           static_cast<float>(loop_.params().matcher.range.min_disparity));
  result.mean_search_width_px = cv::mean(maps_.search_width_px)[0];
  result.searched_fraction = result.mean_search_width_px / loop_.params().matcher.range.count;
  maps_ = DisparityOutput();  // views of the messages' memory
  pair_ = StereoPair();
  return result;
}

// The messages, and `maps_` as views of their memory.
DisparityMessages DisparityProcessor::allocate() {
  DisparityMessages messages;
  messages.left = pair_.left;
  messages.left_info = pair_.left_info;
  messages.rig = rig_;
  messages.disparity = disparityImage(maps_.disparity_px);
  messages.measured_disparity = disparityImage(maps_.measured_disparity_px);
  messages.predicted_disparity = disparityImage(maps_.predicted_disparity_px);
  messages.disparity_variance = image(maps_.disparity_variance_px2);
  messages.measured_variance = image(maps_.measured_variance_px2);
  messages.predicted_variance = image(maps_.predicted_variance_px2);
  messages.search_range = image(maps_.search_width_px);
  return messages;
}

template <class Pixel>
sensor_msgs::ImagePtr DisparityProcessor::image(cv::Mat_<Pixel>& map) {
  namespace encodings = sensor_msgs::image_encodings;
  sensor_msgs::ImagePtr message = images_.take();
  allocateImage(pair_.left->header, rig_.size,
                std::is_same_v<Pixel, float> ? encodings::TYPE_32FC1 : encodings::TYPE_16UC1,
                *message);
  map = writableView<Pixel>(*message);
  return message;
}

stereo_msgs::DisparityImagePtr DisparityProcessor::disparityImage(cv::Mat1f& map) {
  const DisparityRange& range = loop_.params().matcher.range;
  stereo_msgs::DisparityImagePtr message = disparities_.take();
  message->header = pair_.left->header;
  allocateImage(pair_.left->header, rig_.size, sensor_msgs::image_encodings::TYPE_32FC1,
                message->image);
  map = writableView<float>(message->image);
  // Depth is f T / disparity: the offset of the principal points is taken off, as in
  // stereo_image_proc. The fields have no room for it.
  message->f = static_cast<float>(rig_.fx_px);
  message->T = static_cast<float>(rig_.baseline_m);
  message->min_disparity = static_cast<float>(range.min_disparity);
  message->max_disparity = static_cast<float>(range.max_disparity());
  message->delta_d = kDisparityStep;
  message->valid_window.width = static_cast<uint32_t>(rig_.size.width);
  message->valid_window.height = static_cast<uint32_t>(rig_.size.height);
  return message;
}

}  // namespace predictive_stereo
