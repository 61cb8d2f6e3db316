/// Follows the camera over a stereo sequence: ego-motion and accumulated pose.
#pragma once

#include <optional>

#include "predictive_stereo/camera_path.h"
#include "predictive_stereo/ego_motion.h"
#include "predictive_stereo/stage_times.h"
#include "predictive_stereo/stereo_frame.h"

namespace predictive_stereo {

/// What is known about one frame from outside. Nothing of it is needed.
struct OdometryHints {
  /// Not 0 where features of the previous frame are ignored. Not used if not of rig.size.
  cv::Mat1b ignored;
  /// Rotation since the previous frame from another sensor, see EgoMotion::estimate.
  std::optional<Eigen::Matrix3d> R_cam_prev;
  /// Pose of the left camera's optical frame in the body whose path PoseEstimate describes, e.g. a
  /// robot's base.
  Eigen::Isometry3d T_body_cam = Eigen::Isometry3d::Identity();
};

struct OdometryOutput {
  EgoMotionEstimate ego_motion;
  /// The frame that ego_motion.motion starts from; nullopt: it was not seen.
  std::optional<Stamp> motion_start;
  PoseEstimate pose;
};

class VisualOdometry {
 public:
  /// @param max_gap_s  [s] a longer gap between two frames breaks the sequence.
  /// @throws std::invalid_argument as EgoMotion does.
  VisualOdometry(const EgoMotionParams& params, double max_gap_s);

  /// Takes a frame. If it does not continue the previous one (time went back, a gap, another
  /// calibration), all earlier frames are forgotten. The pose goes on over a gap, see CameraPath.
  /// If time went back, it starts at the origin again.
  /// If the result says isIgnored(), follow() must not be called.
  /// @throws std::invalid_argument if an image does not have rig.size; the state is then unchanged.
  SequenceGuard::Result begin(const StereoFrame& frame);
  /// Estimates the motion to the frame that begin() took.
  const OdometryOutput& follow(const OdometryHints& hints = {});
  /// begin() and follow() in one call; of a frame that is ignored it returns the last output.
  const OdometryOutput& process(const StereoFrame& frame, const OdometryHints& hints = {}) {
    const bool ignored = begin(frame).isIgnored();
    return ignored ? output_ : follow(hints);
  }

  /// Whether the poses start with the frame that begin() took.
  bool isOrigin() const { return path_.empty(); }
  /// Pose of the body in the frame that the poses start with; without this call it is identity.
  void setOrigin(const Eigen::Isometry3d& T_odom_body) { path_.setOrigin(T_odom_body); }
  /// Sets parameters for the next frame, see EgoMotion::setParams.
  void setParams(const EgoMotionParams& params);
  /// Forgets everything: the poses start with the next frame.
  void reset();
  /// Of the last frame.
  const StageTimes& times() const { return times_; }

 private:
  void startAnew();
  void forgetFrames();

  EgoMotionParams params_;
  EgoMotion ego_motion_;
  CameraPath path_;
  SequenceGuard guard_;
  StereoFrame frame_;  // that begin() took
  Stamp previous_stamp_{};
  bool has_previous_ = false;  // whether the frame follows another one
  OdometryOutput output_;
  StageTimes times_;
};

}  // namespace predictive_stereo
