/// A camera that drives straight ahead, and its past frames.
#pragma once

#include <map>

#include "detection/frame_history.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

constexpr double kAhead_mps = 8;

/// A rig with KITTI's field of view per pixel, and the principal point in the middle.
inline StereoRig drivingRig(cv::Size size) {
  StereoRig rig;
  rig.size = size;
  rig.fx_px = rig.fy_px = 720;
  rig.cx_left_px = rig.cx_right_px = 0.5 * size.width;
  rig.cy_px = 0.5 * size.height;
  rig.baseline_m = 0.54;
  return rig;
}

/// Disparity [px] at a depth.
inline float disparityOf(const StereoRig& rig, double depth_m) {
  return static_cast<float>(rig.disparityTimesDepth() / depth_m);
}

/// Past frames, selected by their age.
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
