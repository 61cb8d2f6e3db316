/// Poses, covariances and what tf knows of them.
#pragma once

#include <geometry_msgs/Pose.h>
#include <geometry_msgs/Transform.h>
#include <nav_msgs/Odometry.h>
#include <tf2/buffer_core.h>

#include <boost/array.hpp>
#include <optional>
#include <string>

#include "predictive_stereo/disparity_motion.h"
#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {

/// The covariance by which this package says "unknown", as other odometry packages do.
constexpr double kUnknownCovariance = 9999;

Eigen::Isometry3d fromMsg(const geometry_msgs::Transform& message);
geometry_msgs::Transform transformMsg(const Eigen::Isometry3d& T);
geometry_msgs::Pose poseMsg(const Eigen::Isometry3d& T);
Matrix6d fromMsg(const boost::array<double, 36>& covariance);
boost::array<double, 36> covarianceMsg(const Matrix6d& covariance);

/// The constant (linear, angular) velocity [1/s] that makes this motion in dt_s, in the frame that
/// moves.
Vector6d constantTwist(const Eigen::Isometry3d& T_prev_now, double dt_s);

/// T_target_source at one instant; none where tf does not have it (yet); `error` then says why.
///
/// tf's interpolation between stored poses leaves rounding errors that depend on which other poses
/// have come in meanwhile. What is looked up is therefore rounded (to 2^-32 m, and the quaternion
/// likewise), so that a recording gives the same result, bit by bit, live and in replay.
std::optional<Eigen::Isometry3d> lookUpTransform(const tf2::BufferCore& tf,
                                                 const std::string& target,
                                                 const std::string& source, ros::Time stamp,
                                                 std::string& error);

/// The camera's motion between two instants against `fixed_frame`, as CameraMotion::T_cam_prev.
std::optional<Eigen::Isometry3d> lookUpCameraMotion(const tf2::BufferCore& tf,
                                                    const std::string& camera, ros::Time previous,
                                                    ros::Time now, const std::string& fixed_frame,
                                                    std::string& error);

/// Whether every variance is kUnknownCovariance or more: the odometry is lost (pose), or has
/// nothing to compare with (twist).
bool poseIsUnknown(const nav_msgs::Odometry& odometry);
bool twistIsUnknown(const nav_msgs::Odometry& odometry);

/// CameraMotion::covariance over dt_s from an odometry's twist; zero where the odometry has no
/// covariance, or none for some axes.
/// @param T_cam_child  from the odometry's child frame to the camera.
Matrix6d motionCovariance(const nav_msgs::Odometry& odometry, double dt_s,
                          const Eigen::Isometry3d& T_cam_child);

}  // namespace predictive_stereo
