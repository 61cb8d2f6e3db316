/// The path of a camera, of motions that were seen and motions that were not.
#pragma once

#include <deque>
#include <optional>

#include "predictive_stereo/ego_motion.h"
#include "predictive_stereo/path_covariance.h"
#include "predictive_stereo/pose_state.h"
#include "predictive_stereo/sequence_guard.h"
#include "predictive_stereo/unseen_motion.h"

namespace predictive_stereo {

/// Pose of a frame, and of the body that carries the camera (the camera itself, if nothing else is
/// given), in the odom frame.
struct PoseEstimate {
  /// A known pose is one that motions lead to; how well it is known, says its covariance: motions
  /// that were not seen, in earlier frames, are part of it.
  PoseState state = PoseState::kLost;
  Eigen::Isometry3d T_odom_cam = Eigen::Isometry3d::Identity();  ///< left camera's optical frame
  Eigen::Isometry3d T_odom_body = Eigen::Isometry3d::Identity();
  /// Of a right-multiplied perturbation (translation [m], rotation [rad]) of T_odom_body, in the
  /// body's frame, since the first frame. In every state: while the camera does not see its motion,
  /// it grows by what is not seen. With variances of 9999 and more nothing is known.
  Matrix6d covariance = Matrix6d::Zero();
  /// Of the camera's motion since the previous frame with a known pose, see
  /// CameraMotion::covariance. unseenCovariance(): a part of that motion was not seen.
  Matrix6d motion_covariance = Matrix6d::Zero();
  /// Mean velocity of the body since the frame that its motion was seen from; none if it was not
  /// seen.
  std::optional<Velocity> velocity;
};

/// Accumulates the pose: the only place that does. A motion that was not seen is one more motion of
/// the path: it goes on with the last velocity (UnseenMotionModel), with its own covariance. If a
/// later motion leads from a frame before the loss, nothing unseen is left in the path.
class CameraPath {
 public:
  /// Whether the next frame is the first one of the path.
  bool empty() const { return !last_known_; }
  /// Pose of the body in the first frame; without this call it is identity.
  void setOrigin(const Eigen::Isometry3d& T_odom_body) { origin_ = T_odom_body; }
  /// Appends a frame.
  /// @param estimate  its motion; not used for the first frame.
  /// @param stamp  after that of the frame before.
  /// @param T_body_cam  of the left camera's optical frame at this stamp.
  void add(const EgoMotionEstimate& estimate, Stamp stamp,
           const Eigen::Isometry3d& T_body_cam = Eigen::Isometry3d::Identity());
  /// Of the last frame.
  const PoseEstimate& pose() const { return pose_; }
  /// The frame that its motion was seen from; none for the first frame or if it was not seen.
  std::optional<Stamp> motionStart() const { return motion_start_; }
  /// No later motion leads from the frames so far, as after a gap. The pose goes on.
  void breakOff() { recent_.clear(); }
  /// Forgets everything: the next frame is the first one.
  void reset() { *this = CameraPath(); }

 private:
  struct Frame {
    Stamp stamp;
    Eigen::Isometry3d T_odom_cam, T_odom_body;
    PathCovariance covariance;
  };
  void append(const Frame& from, const CameraMotion& motion, const CommonErrors& common,
              Stamp stamp, const Eigen::Isometry3d& T_body_cam);
  const Frame* startOf(const EgoMotionEstimate& estimate) const;

  Eigen::Isometry3d origin_ = Eigen::Isometry3d::Identity();
  std::optional<Frame> last_known_;
  Velocity velocity_ = Velocity::unknown();  // in that frame
  std::deque<Frame> recent_;  // that frame and those after it, as far as motions can start there
  PoseEstimate pose_;
  std::optional<Stamp> motion_start_;
};

}  // namespace predictive_stereo
