#pragma once

#include <sensor_msgs/Image.h>
#include <stereo_msgs/DisparityImage.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/core.hpp>
#include <string>

#include "nodelets/message_pool.h"
#include "nodelets/nodelet_params.h"
#include "nodelets/stereo_messages.h"
#include "predictive_stereo/disparity_loop.h"
#include "predictive_stereo/simd_target.h"

namespace predictive_stereo {

/// The outputs of a frame. Those that MovingObjects needs are the base.
struct DisparityMessages : MovingObjectsInput {
  stereo_msgs::DisparityImagePtr disparity;
  sensor_msgs::ImagePtr disparity_variance, search_range;

  StereoRig rig;           ///< of the pair, as calibrated
  bool predicted = false;  ///< whether the past was used
  /// Share of the pixels with both a predicted and a measured disparity where the two contradict
  /// each other.
  double contradicted_fraction = 0;
  double mean_search_width_px = 0;  ///< over all pixels
  double searched_fraction = 0;     ///< share of all (pixel, disparity) pairs that was searched
};

/// Disparity messages from pairs; used by the Disparity nodelet and by `replay`. The core writes
/// directly into the memory of the messages.
class DisparityProcessor {
 public:
  /// Inputs of a frame from other nodelets. Without `motion` it is not known.
  struct Sources {
    DisparityLoop::Motion motion;
    DisparityLoop::Moved moved;
    /// Called before the published disparity is made; may be empty.
    std::function<void(const MovingObjectsInput&)> measured;
    ColumnOffset column_offset;
  };

  using Output = DisparityMessages;

  explicit DisparityProcessor(const DisparityNodeletParams& params)
      : robot_mask_(readRobotMask(params.robot_mask)), loop_(params.disparity, params.max_gap) {
    validate(params);
  }

  /// See Pipeline::begin.
  /// @throws std::invalid_argument for a pair that cannot be used; the state stays as it was.
  SequenceGuard::Result begin(const StereoPair& pair) {
    const StereoFrame frame = stereoFrame(pair, robot_mask_);
    const SequenceGuard::Result sequence = loop_.begin(frame);
    if (sequence.isIgnored()) return sequence;
    pair_ = pair;
    rig_ = frame.rig;
    return sequence;
  }

  /// Processes the pair of the last begin(); see Pipeline::process.
  DisparityMessages process(const Sources& sources) {
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

  /// See DisparityLoop::setParams.
  void setParams(const DisparityParams& params) { loop_.setParams(params); }

  void reset() { loop_.reset(); }

  const std::string& simdTarget() const { return loop_.simdTarget(); }
  /// See simd_target.h; empty: no warning.
  std::string slowTargetWarning() const {
    return predictive_stereo::slowTargetWarning(loop_.params().matcher.simd_target, simdTarget());
  }
  const StageTimes& times() const { return loop_.times(); }

 private:
  // Resolution of the sub-pixel interpolation: costs are integers of at most a few hundred.
  static constexpr float kDisparityStep = 1.0f / 16;

  // See DisparityMessages::contradicted_fraction; 0 if only a few pixels are predicted.
  static double contradictedFraction(const cv::Mat1f& predicted_px, const cv::Mat1f& measured_px,
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

  // The messages, and `maps_` as views of their memory.
  DisparityMessages allocate() {
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
  sensor_msgs::ImagePtr image(cv::Mat_<Pixel>& map) {
    sensor_msgs::ImagePtr message = images_.take();
    map = allocateImage<Pixel>(pair_.left->header, rig_.size, *message);
    return message;
  }

  stereo_msgs::DisparityImagePtr disparityImage(cv::Mat1f& map) {
    const DisparityRange& range = loop_.params().matcher.range;
    stereo_msgs::DisparityImagePtr message = disparities_.take();
    message->header = pair_.left->header;
    map = allocateImage<float>(pair_.left->header, rig_.size, message->image);
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

  const cv::Mat1b robot_mask_;
  DisparityLoop loop_;
  MessagePool<sensor_msgs::Image> images_;
  MessagePool<stereo_msgs::DisparityImage> disparities_;

  // Of the current frame.
  StereoPair pair_;
  DisparityOutput maps_;
  StereoRig rig_;
};

}  // namespace predictive_stereo
