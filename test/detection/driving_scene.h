/// A camera that drives straight ahead, and what it has seen on its way.
#pragma once

#include <map>

#include "detection/frame_history.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

constexpr double kAhead_mps = 8;

/// Of KITTI's field of view per pixel, with the principal point in the middle.
inline StereoRig drivingRig(cv::Size size) {
  StereoRig rig;
  rig.size = size;
  rig.fx_px = rig.fy_px = 720;
  rig.cx_left_px = rig.cx_right_px = 0.5 * size.width;
  rig.cy_px = 0.5 * size.height;
  rig.baseline_m = 0.54;
  return rig;
}

/// The disparity of what is this far away [px].
inline float disparityOf(const StereoRig& rig, double depth_m) {
  return static_cast<float>(rig.disparityTimesDepth() / depth_m);
}

/// Frames of the past, by how long ago they were.
class DrivenWay {
 public:
  void remember(double seconds, const cv::Mat1f& disparity_px) {
    frames_[seconds].disparity_px = disparity_px;
  }
  RememberedFrame& frame(double seconds) { return frames_.at(seconds); }
  PastFrame past(double seconds) const {
    PastFrame past;
    past.frame = &frames_.at(seconds);
    past.T_past_cam.translation().z() = kAhead_mps * seconds;
    past.seconds = seconds;
    return past;
  }

 private:
  std::map<double, RememberedFrame> frames_;
};

}  // namespace predictive_stereo
