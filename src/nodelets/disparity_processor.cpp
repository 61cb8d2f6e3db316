#include "nodelets/disparity_processor.h"

#include <sensor_msgs/image_encodings.h>

#include <boost/make_shared.hpp>
#include <opencv2/core.hpp>
#include <utility>

#include "nodelets/image_messages.h"

namespace predictive_stereo {
namespace {

// The sub-pixel formula's resolution: costs are integers of at most a few hundred.
constexpr float kDisparityStep = 1.0f / 16;

}  // namespace

DisparityProcessor::DisparityProcessor(const DisparityProcessorParams& params)
    : params_(params), estimator_(params.disparity), guard_(params.max_gap) {
  validate(params);
}

void DisparityProcessor::setParams(const DisparityParams& params) {
  estimator_.setParams(params);
  params_.disparity = params;
}

void DisparityProcessor::reset() {
  estimator_.reset();
  guard_.forget();
  previous_stamp_.reset();
}

SequenceGuard::Result DisparityProcessor::begin(const StereoPair& pair) {
  const StereoRig rig = stereoRig(pair);
  const cv::Mat1b left = greyImage(*pair.left, "left", left_buffer_);
  const cv::Mat1b right = greyImage(*pair.right, "right", right_buffer_);

  const SequenceGuard::Result sequence = guard_.next(pair.left->header.stamp, rig);
  if (sequence.verdict == SequenceGuard::Verdict::kDuplicate) return sequence;
  if (sequence.verdict != SequenceGuard::Verdict::kContinues) {
    estimator_.reset();
    previous_stamp_.reset();
  }
  pair_ = pair;
  rig_ = rig;
  estimator_.begin(left, right, rig);
  return sequence;
}

void DisparityProcessor::predict(const std::optional<CameraMotion>& motion) {
  DisparityMessages& result = messages_;
  result = DisparityMessages();
  result.disparity = disparityImage();
  result.measured_disparity = disparityImage();
  result.predicted_disparity = disparityImage();
  result.disparity_variance = image(sensor_msgs::image_encodings::TYPE_32FC1);
  result.measured_variance = image(sensor_msgs::image_encodings::TYPE_32FC1);
  result.predicted_variance = image(sensor_msgs::image_encodings::TYPE_32FC1);
  result.search_range = image(sensor_msgs::image_encodings::TYPE_16UC1);

  DisparityOutput& output = output_;
  output.disparity_px = writableView<float>(result.disparity->image);
  output.measured_disparity_px = writableView<float>(result.measured_disparity->image);
  output.predicted_disparity_px = writableView<float>(result.predicted_disparity->image);
  output.disparity_variance_px2 = writableView<float>(*result.disparity_variance);
  output.measured_variance_px2 = writableView<float>(*result.measured_variance);
  output.predicted_variance_px2 = writableView<float>(*result.predicted_variance);
  output.search_width_px = writableView<uint16_t>(*result.search_range);
  estimator_.predict(motion, output);
}

DisparityMessages DisparityProcessor::estimate() {
  DisparityMessages& result = messages_;
  DisparityOutput& output = output_;
  estimator_.measure(output);

  result.row_alignment = boost::make_shared<RowAlignment>();
  result.row_alignment->header = pair_.left->header;
  for (int i = 0; i < 6; ++i)
    result.row_alignment->coefficients[i] = output.row_alignment.coefficients_px(i);
  result.row_alignment->samples = static_cast<uint32_t>(output.row_alignment.samples);
  result.row_alignment->residual = output.row_alignment.residual_px;
  result.row_alignment->largest_offset = output.row_alignment.largest_offset_px;

  result.predicted = output.predicted;
  result.mean_search_width_px = cv::mean(output.search_width_px)[0];
  result.searched_fraction = result.mean_search_width_px / params_.disparity.matcher.range.count;
  if (output.carried) previous_stamp_ = pair_.left->header.stamp;
  pair_ = StereoPair();
  return std::move(messages_);
}

void DisparityProcessor::finish() {
  estimator_.publish(output_);
  output_ = DisparityOutput();  // the messages' memory is theirs
}

void DisparityProcessor::markMoving(const sensor_msgs::Image& mask) {
  cv::Mat1b unused;
  estimator_.markMoving(greyImage(mask, "moving_objects/mask", unused));
}

sensor_msgs::ImagePtr DisparityProcessor::image(const std::string& encoding) {
  sensor_msgs::ImagePtr message = images_.take();
  allocateImage(pair_.left->header, rig_.size, encoding, *message);
  return message;
}

stereo_msgs::DisparityImagePtr DisparityProcessor::disparityImage() {
  const DisparityRange& range = params_.disparity.matcher.range;
  stereo_msgs::DisparityImagePtr message = disparities_.take();
  message->header = pair_.left->header;
  allocateImage(pair_.left->header, rig_.size, sensor_msgs::image_encodings::TYPE_32FC1,
                message->image);
  message->f = static_cast<float>(rig_.fx_px);
  message->T = static_cast<float>(rig_.baseline_m);
  message->min_disparity = static_cast<float>(range.min_disparity);
  message->max_disparity = static_cast<float>(range.max_disparity());
  message->delta_d = kDisparityStep;
  message->valid_window.x_offset = 0;
  message->valid_window.y_offset = 0;
  message->valid_window.width = static_cast<uint32_t>(rig_.size.width);
  message->valid_window.height = static_cast<uint32_t>(rig_.size.height);
  message->valid_window.do_rectify = false;
  return message;
}

}  // namespace predictive_stereo
