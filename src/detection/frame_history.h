/// What the detector keeps of the frames before the current one.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <functional>
#include <opencv2/core.hpp>
#include <vector>

#include "odometry/image_pyramid.h"
#include "predictive_stereo/moving_objects.h"

namespace predictive_stereo {

struct RememberedFrame {
  double stamp_s = 0;
  bool has_pose = false;
  bool follows = true;  ///< the pose goes on from that of the frame before, as the images do
  Eigen::Isometry3d T_odom_cam = Eigen::Isometry3d::Identity();
  ImagePyramid pyramid;
  cv::Mat1f disparity_px;  ///< as measured

  bool empty() const { return pyramid.empty(); }
};

/// A frame of the past, as seen from the current one.
struct PastFrame {
  const RememberedFrame* frame = nullptr;
  Eigen::Isometry3d T_past_cam = Eigen::Isometry3d::Identity();
  double seconds = 0;  ///< since then
};

class FrameHistory {
 public:
  /// Frames back that are kept.
  static constexpr int kFarthest = 8;

  using Task = std::function<void()>;
  /// Makes it the current frame, and the one before it one of the past.
  /// @param beside  what is done at the same time, and needs nothing of this.
  void remember(const DetectionInput& input, const std::vector<Task>& beside = {});
  const RememberedFrame& current() const { return frames_[0]; }
  /// The right image's columns are corrected otherwise from now on: `step_px` is added to the
  /// disparities of the past.
  void addToDisparities(const DisparityRange& range, double step_px);
  void setFollows(bool follows) { frames_[0].follows = follows; }
  /// Frames before the current one, the last first, as far as poses and stamps go on. Valid until
  /// the next frame.
  std::vector<PastFrame> past() const;
  void reset();

 private:
  /// The current frame first, then the one before it, and so on.
  std::array<RememberedFrame, 1 + kFarthest> frames_;
};

}  // namespace predictive_stereo
