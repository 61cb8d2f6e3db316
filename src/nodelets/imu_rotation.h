#pragma once

#include <ros/time.h>
#include <sensor_msgs/Imu.h>

#include <Eigen/Core>
#include <deque>
#include <mutex>
#include <optional>
#include <string>

namespace predictive_stereo {

/// Rotation of an IMU between two instants: integrates the angular velocities of its gyroscope,
/// interpolated linearly.
///
/// Thread-safe.
class ImuRotation {
 public:
  struct Answer {
    /// Maps directions from the IMU's axes at the first instant to those at the second one.
    std::optional<Eigen::Matrix3d> R_now_previous;
    std::string reason;    ///< why there is no rotation
    bool complete = true;  ///< false: missing measurements may still arrive
  };

  /// Adds a measurement. If its stamp went back, earlier ones are dropped. Measurements that are
  /// not finite are ignored.
  void add(const sensor_msgs::ImuConstPtr& imu);

  Answer between(ros::Time previous, ros::Time now) const;

  /// Updates the bias with the mean angular velocity of an interval in which the camera did not
  /// move.
  void learnBias(ros::Time previous, ros::Time now);

  /// Frame of the measurements; empty: no measurements.
  std::string frame() const;
  Eigen::Vector3d bias_radps() const;

 private:
  static constexpr double kKept_s = 3;
  static constexpr double kLargestGap_s = 0.1;  // between two measurements
  static constexpr double kBiasWeight = 0.1;    // of the newest interval; 1 for the first one

  struct Sample {
    ros::Time stamp;
    Eigen::Vector3d rate_radps;
  };

  // Calls `use` with the mean angular velocity and the duration of each step between two samples,
  // clipped to the interval.
  template <class Use>
  std::string forEachStep(ros::Time previous, ros::Time now, bool& complete, const Use& use) const;

  mutable std::mutex mutex_;
  std::string frame_;
  bool has_gyro_ = true;
  std::deque<Sample> samples_;
  std::optional<Eigen::Vector3d> bias_radps_;
};

}  // namespace predictive_stereo
