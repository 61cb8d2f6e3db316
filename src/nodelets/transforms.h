/// Frames, poses and motions: conversions from and to messages, those of the camera from tf and
/// odometry.
#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Odometry.h>
#include <tf2/buffer_core.h>

#include <boost/array.hpp>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "nodelets/message_history.h"
#include "predictive_stereo/disparity_motion.h"
#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {

/// Frame ids in tf2 have no leading slash, but some publishers still add one.
inline std::string withoutSlash(const std::string& frame) {
  return !frame.empty() && frame[0] == '/' ? frame.substr(1) : frame;
}

/// Frames that static transforms fix to others. A frame must have one parent: only their root can
/// be moved by an odometry.
class FixedFrames {
 public:
  void add(const std::string& child, const std::string& parent) {
    parents_[withoutSlash(child)] = withoutSlash(parent);
  }

  /// The root of the static frames above this one; itself if it is fixed to none.
  std::string rootOf(std::string frame) const {
    frame = withoutSlash(frame);
    std::set<std::string> seen;  // a wrong tree may have a circle
    for (auto parent = parents_.find(frame); parent != parents_.end() && seen.insert(frame).second;
         parent = parents_.find(frame))
      frame = parent->second;
    return frame;
  }

 private:
  std::map<std::string, std::string> parents_;  // by child
};

/// Variance that means "unknown" in this package, as in other odometry packages.
constexpr double kUnknownCovariance = 9999;

Eigen::Isometry3d fromMsg(const geometry_msgs::Transform& message);
geometry_msgs::TransformStamped transformMsg(ros::Time stamp, const std::string& parent,
                                             const std::string& child,
                                             const Eigen::Isometry3d& T_parent_child);
Matrix6d fromMsg(const boost::array<double, 36>& covariance);
boost::array<double, 36> covarianceMsg(const Matrix6d& covariance);

/// T_target_source at one instant; none if tf does not have it (yet): `error` then says why.
///
/// The interpolation of tf has rounding errors that depend on the other poses in the buffer. So the
/// result is rounded (to 2^-32 m, and the quaternion likewise): then a recording gives
/// bit-identical results live and in replay.
std::optional<Eigen::Isometry3d> lookUpTransform(const tf2::BufferCore& tf,
                                                 const std::string& target,
                                                 const std::string& source, ros::Time stamp,
                                                 std::string& error);

/// Why a mount of the left camera is hardly meant so; empty: it may be. A frame with the axes of
/// the base, as camera_link has, makes a camera that looks ahead one that looks up. Upside down:
/// MovingObjects expects the ground below.
std::string doubtAboutMount(const Eigen::Isometry3d& T_base_cam, const std::string& base,
                            const std::string& camera);

/// The camera's motion between two instants relative to `fixed_frame`, as CameraMotion::T_cam_prev.
std::optional<Eigen::Isometry3d> lookUpCameraMotion(const tf2::BufferCore& tf,
                                                    const std::string& camera, ros::Time previous,
                                                    ros::Time now, const std::string& fixed_frame,
                                                    std::string& error);

/// Whether every variance of the twist is kUnknownCovariance or more: the odometry is lost, or
/// there is no previous frame.
bool twistIsUnknown(const nav_msgs::Odometry& odometry);

/// CameraMotion::covariance over dt_s, from the twist of an odometry. Axes whose variance it does
/// not tell (zero, kUnknownCovariance or more), as wheels do not, get that of untoldCovariance().
/// Zero (unknown) if it tells none, or if one is negative or not finite.
/// @param T_cam_child  from the odometry's child frame to the camera.
Matrix6d motionCovariance(const nav_msgs::Odometry& odometry, double dt_s,
                          const Eigen::Isometry3d& T_cam_child);

using OdometryHistory = MessageHistory<nav_msgs::Odometry>;

/// A motion or pose of the camera, or the reason why it is unknown.
template <class Value>
struct Answer {
  std::optional<Value> value;
  bool complete = false;  ///< waiting longer does not help
  std::string reason;     ///< why there is no value; or, with a value, no covariance
};
using MotionAnswer = Answer<CameraMotion>;
using PoseAnswer = Answer<CameraPose>;

/// The motion from tf, and its covariance from odometry of any source. If the poses of the odometry
/// say another motion, tf is moved by another source, as wheels: the square of the difference is
/// added, as it is an error of one of both.
/// @param odometry  nullptr: no odometry; the covariance is then zero (unknown).
/// @returns no motion, too, if tf has the odometry's, and this did not see a part of it: the poses
///   in tf are then partly a guess. It is lost where its twist is unknown (twistIsUnknown).
MotionAnswer cameraMotion(const tf2::BufferCore& tf, const OdometryHistory* odometry,
                          const std::string& camera, ros::Time previous, ros::Time now,
                          const std::string& fixed_frame);

/// The pose from tf, and the covariance of the motion since `previous` as cameraMotion gives it.
/// @param previous  the last frame with a pose; none, or not before `now`: there is none.
/// @returns no pose if tf has the odometry's, and this is lost in this frame.
PoseAnswer cameraPose(const tf2::BufferCore& tf, const OdometryHistory* odometry,
                      const std::string& camera, std::optional<ros::Time> previous, ros::Time now,
                      const std::string& fixed_frame);

}  // namespace predictive_stereo
