/// The frames that are compared: the current one, and past ones.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "detection/depth_cells.h"
#include "detection/frame_comparison.h"
#include "detection/ground_plane.h"
#include "detection/obstacles.h"
#include "imaging/image_pyramid.h"
#include "predictive_stereo/moving_objects.h"
#include "predictive_stereo/path_covariance.h"

namespace predictive_stereo {

/// A frame as the detector remembers it.
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
  /// Number of past frames that are kept: the previous one, and others that are at least
  /// kLeastApart_s apart.
  static constexpr int kFarthest = 8;

  /// Adds a frame, which becomes the current one.
  void remember(const DetectionInput& input);
  const RememberedFrame& current() const { return frames_[0]; }
  /// Whether a frame shows the image of the current one again, for at most kLongestGap_s: camera
  /// drivers send it if the next image is late. Noise tells the images of a live camera apart.
  bool isShownAgain(const DetectionInput& input) const;
  /// Adds `step_px` to the disparities of the past, after a change of the column correction.
  void addToDisparities(const DisparityRange& range, double step_px);
  void setFollows(bool follows) { frames_[0].follows = follows; }
  /// Past frames, the last one first, as far back as poses and stamps are consistent. Valid until
  /// the next frame.
  std::vector<PastFrame> past() const;
  void reset();

 private:
  void continueMotions(const DetectionInput& input);
  bool secondLastStays() const;

  /// The current frame, then the previous ones, the last one first.
  std::array<RememberedFrame, 1 + kFarthest> frames_;
};

/// Detects wrong poses: with a wrong pose nearly the whole image contradicts a static world. A pose
/// counts as wrong if the contradicting share is very large or grows suddenly, for at most two
/// frames in a row; a large share that lasts longer is accepted.
class PoseCheck {
 public:
  /// Whether the image agrees with the camera's motion since the previous frame as well as usual.
  /// @param contradicting  share of the image that a static world does not explain.
  bool agreesWithMotion(double contradicting);
  /// Whether it is so large that no object in view explains it.
  static bool contradictsMost(double contradicting);
  void reset() { *this = PoseCheck(); }

 private:
  std::optional<double> usual_;
  int odd_frames_ = 0;  ///< in a row
};

struct PastView;

/// The current frame, for all parts of the detector.
struct FrameView {
  const DetectionInput& input;
  const DisparityRange& range;
  const MotionDetectionParams& params;
  const RememberedFrame& current;
  const DepthCells& cells;
  const std::optional<GroundPlane>& ground;  ///< none: this frame shows none
  const Obstacles& obstacles;

  cv::Size lattice() const { return current.pyramid.level(1).size(); }
  /// @param past  must outlive the view, as this frame must.
  PastView since(const PastFrame& past) const;
};

/// The current frame, and a past one that it is compared with.
struct PastView {
  const FrameView& frame;
  const PastFrame& past;
  SourceOf static_source;  ///< where static points were

  const StereoRig& rig() const { return frame.input.rig; }
  const MotionDetectionParams& params() const { return frame.params; }
  const cv::Mat1f& disparity_px() const { return frame.input.measured_disparity_px; }
  bool isKnown(float disparity_px) const { return frame.range.isValid(disparity_px); }
  const ImagePyramid& images() const { return frame.current.pyramid; }
  const ImagePyramid& past_images() const { return past.frame->pyramid; }
  /// Where a pixel was if it is static.
  Eigen::Vector3f staticSource(cv::Point pixel) const {
    return static_source(static_cast<float>(pixel.x), static_cast<float>(pixel.y),
                         disparity_px()(pixel));
  }
  /// See compareFrames.
  void compare(const SourceOf& source_of, const cv::Rect& area, cv::Mat1f& mismatch) const {
    compareFrames(images(), frame.cells.lattice_px, past_images(), source_of, area, mismatch);
  }
};

inline PastView FrameView::since(const PastFrame& past) const {
  return {*this, past, SourceOf(disparityMotion(input.rig, past.T_past_cam))};
}

}  // namespace predictive_stereo
