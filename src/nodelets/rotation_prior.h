#pragma once

#include <ros/node_handle.h>
#include <std_msgs/Header.h>

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "nodelets/arrivals.h"
#include "nodelets/callbacks.h"
#include "nodelets/imu_rotation.h"
#include "nodelets/nodelet_params.h"
#include "nodelets/tf_input.h"
#include "predictive_stereo/ego_motion.h"

namespace predictive_stereo {

/// The camera's rotation since the previous frame from another sensor: an IMU (use_imu) or another
/// odometry in tf (guess_frame).
class RotationPrior {
 public:
  RotationPrior(const ros::NodeHandle& node, Health& health, Arrivals& arrivals, TfInput& tf,
                const EgoMotionNodeletParams& params)
      : node_(node), health_(health), arrivals_(arrivals), tf_(tf), params_(params) {}

  void start();
  /// After this has returned, nothing is received.
  void stop() { subscription_.shutdown(); }

  /// @param previous  zero: there is no previous frame.
  std::optional<Eigen::Matrix3d> since(ros::Time previous, const std_msgs::Header& now);
  /// At rest a gyroscope measures its bias.
  void learnBias(ros::Time previous, ros::Time now, const EgoMotionEstimate& estimate);

 private:
  std::optional<Eigen::Matrix3d> fromImu(ros::Time previous, const std_msgs::Header& now);
  std::optional<Eigen::Matrix3d> fromTf(ros::Time previous, const std_msgs::Header& now);

  ros::NodeHandle node_;
  Health& health_;
  Arrivals& arrivals_;
  TfInput& tf_;
  const EgoMotionNodeletParams& params_;
  ImuRotation imu_;
  Subscription subscription_;
  bool is_late_ = false;  // do not wait for it again until it has arrived
};

}  // namespace predictive_stereo
