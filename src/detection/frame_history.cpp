#include "detection/frame_history.h"

#include <algorithm>

namespace predictive_stereo {
namespace {

constexpr int kPyramidLevels = 4;

}  // namespace

void FrameHistory::remember(const DetectionInput& input) {
  std::rotate(frames_.begin(), frames_.end() - 1, frames_.end());
  RememberedFrame& current = frames_[0];
  current.stamp_s = input.stamp_s;
  current.has_pose = input.has_pose;
  current.follows = true;
  current.T_odom_cam = input.T_odom_cam;
  constexpr int kParts = 2;  // of about the same length
  cv::parallel_for_(cv::Range(0, kParts), [&](const cv::Range& parts) {
    for (int part = parts.start; part < parts.end; ++part)
      if (part == 0)
        current.pyramid.build(input.left, kPyramidLevels);
      else
        input.measured_disparity_px.copyTo(current.disparity_px);
  });
}

std::vector<PastFrame> FrameHistory::past() const {
  std::vector<PastFrame> past;
  const RememberedFrame& current = frames_[0];
  for (size_t k = 1; k < frames_.size(); ++k) {
    const RememberedFrame& frame = frames_[k];
    if (frame.empty() || !current.has_pose || !frame.has_pose || !frames_[k - 1].follows ||
        !(frame.stamp_s < frames_[k - 1].stamp_s))
      break;
    past.push_back(
        {&frame, frame.T_odom_cam.inverse() * current.T_odom_cam, current.stamp_s - frame.stamp_s});
  }
  return past;
}

void FrameHistory::reset() {
  for (RememberedFrame& frame : frames_) frame = RememberedFrame();
}

}  // namespace predictive_stereo
