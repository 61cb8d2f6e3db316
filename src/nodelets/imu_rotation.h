#pragma once

#include <ros/time.h>
#include <sensor_msgs/Imu.h>

#include <Eigen/Core>
#include <deque>
#include <mutex>
#include <optional>
#include <string>

namespace predictive_stereo {

/// How an IMU turned from one instant to another, by its gyroscope: rates are integrated, linear
/// between two measurements.
///
/// Thread-safe.
class ImuRotation {
 public:
  struct Answer {
    /// Takes directions in the IMU's axes at the first instant to those at the second; none: why.
    std::optional<Eigen::Matrix3d> R_now_previous;
    std::string reason;
    bool complete = true;  ///< false: what is missing may still come
  };

  /// A measurement. One whose stamp goes back starts anew. What is not finite is left out.
  void add(const sensor_msgs::ImuConstPtr& imu);

  Answer between(ros::Time previous, ros::Time now) const;

  /// The camera stood still in between: what was measured is the bias.
  void learnBias(ros::Time previous, ros::Time now);

  /// Frame of the measurements; empty: there are none.
  std::string frame() const;
  Eigen::Vector3d bias_radps() const;

 private:
  static constexpr double kKept_s = 3;
  static constexpr double kLargestGap_s = 0.1;  // between two measurements
  static constexpr double kBiasWeight = 0.1;    // of the newest; the first counts whole

  struct Sample {
    ros::Time stamp;
    Eigen::Vector3d rate_radps;
  };

  // The mean rate's rotation from one sample to the next, for the part that is in between.
  template <class Use>
  std::string forEachStep(ros::Time previous, ros::Time now, bool& complete, const Use& use) const;

  mutable std::mutex mutex_;
  std::string frame_;
  bool has_gyro_ = true;
  std::deque<Sample> samples_;
  std::optional<Eigen::Vector3d> bias_radps_;
};

}  // namespace predictive_stereo
