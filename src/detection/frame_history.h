/// A frame as the detector remembers it.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <functional>
#include <opencv2/core.hpp>
#include <vector>

#include "imaging/image_pyramid.h"
#include "predictive_stereo/moving_objects.h"
#include "predictive_stereo/path_covariance.h"

namespace predictive_stereo {

struct RememberedFrame {
  double stamp_s = 0;
  PoseState pose_state = PoseState::kLost;
  bool follows = true;  ///< whether its pose is known relative to that of the previous frame
  Eigen::Isometry3d T_odom_cam = Eigen::Isometry3d::Identity();
  PathCovariance motion_since;  ///< of the camera, until the current frame
  ImagePyramid pyramid;
  cv::Mat1f disparity_px;  ///< measured

  bool empty() const { return pyramid.empty(); }
};

/// A past frame and its pose relative to the current one.
struct PastFrame {
  const RememberedFrame* frame = nullptr;
  Eigen::Isometry3d T_past_cam = Eigen::Isometry3d::Identity();
  Matrix6d motion_covariance = Matrix6d::Zero();  ///< see CameraMotion::covariance
  double seconds = 0;                             ///< between that frame and the current one
};

class FrameHistory {
 public:
  /// Number of past frames that are kept.
  static constexpr int kFarthest = 8;

  using Task = std::function<void()>;
  /// Adds a frame, which becomes the current one.
  /// @param beside  independent tasks that run at the same time.
  void remember(const DetectionInput& input, const std::vector<Task>& beside = {});
  const RememberedFrame& current() const { return frames_[0]; }
  /// Adds `step_px` to the disparities of the past, after a change of the column correction.
  void addToDisparities(const DisparityRange& range, double step_px);
  void setFollows(bool follows) { frames_[0].follows = follows; }
  /// Past frames, the last one first, as far back as poses and stamps are consistent. Valid until
  /// the next frame.
  std::vector<PastFrame> past() const;
  void reset();

 private:
  void continueMotions(const DetectionInput& input);

  /// The current frame, then the previous ones, the last one first.
  std::array<RememberedFrame, 1 + kFarthest> frames_;
};

}  // namespace predictive_stereo
