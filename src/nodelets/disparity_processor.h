#pragma once

#include <sensor_msgs/Image.h>
#include <stereo_msgs/DisparityImage.h>

#include <functional>

#include "nodelets/message_pool.h"
#include "nodelets/nodelet_params.h"
#include "nodelets/stereo_messages.h"
#include "predictive_stereo/disparity_loop.h"

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

  explicit DisparityProcessor(const DisparityNodeletParams& params);

  /// See Pipeline::begin.
  /// @throws std::invalid_argument for a pair that cannot be used; the state stays as it was.
  SequenceGuard::Result begin(const StereoPair& pair);
  /// Processes the pair of the last begin(); see Pipeline::process.
  DisparityMessages process(const Sources& sources);

  /// See DisparityLoop::setParams.
  void setParams(const DisparityParams& params) { loop_.setParams(params); }

  void reset() { loop_.reset(); }

  const std::string& simdTarget() const { return loop_.simdTarget(); }
  /// See simd_target.h; empty: no warning.
  std::string slowTargetWarning() const;
  const StageTimes& times() const { return loop_.times(); }

 private:
  DisparityMessages allocate();
  template <class Pixel>
  sensor_msgs::ImagePtr image(cv::Mat_<Pixel>& map);
  stereo_msgs::DisparityImagePtr disparityImage(cv::Mat1f& map);

  DisparityLoop loop_;
  cv::Mat1b left_buffer_, right_buffer_;
  MessagePool<sensor_msgs::Image> images_;
  MessagePool<stereo_msgs::DisparityImage> disparities_;

  // Of the current frame.
  StereoPair pair_;
  DisparityOutput maps_;
  StereoRig rig_;
};

}  // namespace predictive_stereo
