#pragma once

#include <ros/node_handle.h>
#include <ros/time.h>
#include <sensor_msgs/Imu.h>
#include <std_msgs/Header.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "nodelets/callbacks.h"
#include "nodelets/message_history.h"
#include "nodelets/nodelet_params.h"
#include "nodelets/tf_input.h"
#include "nodelets/threads.h"
#include "nodelets/transforms.h"
#include "predictive_stereo/ego_motion.h"

namespace predictive_stereo {

/// Rotation of an IMU between two instants: integrates the angular velocities of its gyroscope,
/// interpolated linearly. Another thread may add measurements.
class ImuRotation {
 public:
  /// Adds a measurement, see requireImu. If its stamp went back, earlier ones are dropped.
  void add(const sensor_msgs::ImuConstPtr& imu) { history_.add(imu); }

  /// R_now_previous, which maps directions from the IMU's axes at the first instant to those at the
  /// second one.
  Answer<Eigen::Matrix3d> between(ros::Time previous, ros::Time now) const;

  /// Updates the bias with the mean angular velocity of an interval in which the camera did not
  /// move.
  void learnBias(ros::Time previous, ros::Time now);
  const Eigen::Vector3d& bias_radps() const { return bias_radps_; }

  /// Frame of the measurements; empty: no measurements.
  std::string frame() const {
    const auto last = history_.last();
    return last ? last->header.frame_id : "";
  }

 private:
  static constexpr double kLargestGap_s = 0.1;  // between two measurements
  static constexpr double kBiasWeight = 0.1;    // of the newest interval; 1 for the first one

  // Between two measurements, or a part of it at both ends of an interval.
  struct Step {
    Eigen::Vector3d mean_rate_radps;
    double duration_s;
  };
  using Steps = std::vector<Step>;
  Answer<Steps> stepsBetween(ros::Time previous, ros::Time now) const;

  MessageHistory<sensor_msgs::Imu> history_;
  Eigen::Vector3d bias_radps_ = Eigen::Vector3d::Zero();
  bool knows_bias_ = false;
};

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
