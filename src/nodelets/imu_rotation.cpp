#include "nodelets/imu_rotation.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "predictive_stereo/rotation_vector.h"

namespace predictive_stereo {
namespace {

constexpr char kCure[] = ": stamp it by the clock of the images, and send it at 20 Hz or more";

}  // namespace

void ImuRotation::add(const sensor_msgs::ImuConstPtr& imu) {
  const auto& w = imu->angular_velocity;
  const Eigen::Vector3d rate_radps(w.x, w.y, w.z);
  const std::lock_guard<std::mutex> lock(mutex_);
  frame_ = imu->header.frame_id;
  // In sensor_msgs/Imu, -1 means that the device does not measure angular velocity.
  has_gyro_ = imu->angular_velocity_covariance[0] != -1;
  if (!has_gyro_ || !rate_radps.allFinite()) return;
  if (!samples_.empty() && imu->header.stamp == samples_.back().stamp) return;
  if (!samples_.empty() && imu->header.stamp < samples_.back().stamp) samples_.clear();
  samples_.push_back({imu->header.stamp, rate_radps});
  while (samples_.back().stamp - samples_.front().stamp > ros::Duration(kKept_s))
    samples_.pop_front();
}

template <class Use>
std::string ImuRotation::forEachStep(ros::Time previous, ros::Time now, bool& complete,
                                     const Use& use) const {
  complete = true;
  if (!has_gyro_) return "angular_velocity_covariance[0] is -1: it measures no angular velocity";
  if (samples_.empty() || samples_.back().stamp < now) {
    complete = false;
    return std::string("its last stamp is before the image's") + kCure;
  }
  if (samples_.front().stamp > previous)
    return std::string("its stamps begin after the previous image's, or jumped back") + kCure;
  for (size_t i = 1; i < samples_.size(); ++i) {
    const Sample &before = samples_[i - 1], &after = samples_[i];
    const double begin_s = std::max(0.0, (previous - before.stamp).toSec());
    const double length_s = (after.stamp - before.stamp).toSec();
    const double end_s = std::min(length_s, (now - before.stamp).toSec());
    if (end_s <= begin_s) continue;
    if (length_s > kLargestGap_s) {
      char text[100];
      std::snprintf(text, sizeof(text), "its stamps jump by %.2f s", length_s);
      return std::string(text) + kCure;
    }
    // Linear interpolation.
    const double middle = (begin_s + end_s) / 2 / length_s;
    use(before.rate_radps + middle * (after.rate_radps - before.rate_radps), end_s - begin_s);
  }
  return "";
}

ImuRotation::Answer ImuRotation::between(ros::Time previous, ros::Time now) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  Answer answer;
  const Eigen::Vector3d bias = bias_radps_.value_or(Eigen::Vector3d::Zero());
  Eigen::Matrix3d R_previous_now = Eigen::Matrix3d::Identity();
  answer.reason = forEachStep(
      previous, now, answer.complete, [&](const Eigen::Vector3d& rate_radps, double dt_s) {
        R_previous_now = R_previous_now * rotationBy((rate_radps - bias) * dt_s);
      });
  if (answer.reason.empty()) answer.R_now_previous = R_previous_now.transpose();
  return answer;
}

void ImuRotation::learnBias(ros::Time previous, ros::Time now) {
  const std::lock_guard<std::mutex> lock(mutex_);
  Eigen::Vector3d angle_rad = Eigen::Vector3d::Zero();
  double time_s = 0;
  bool complete;
  const std::string reason =
      forEachStep(previous, now, complete, [&](const Eigen::Vector3d& rate_radps, double dt_s) {
        angle_rad += rate_radps * dt_s;
        time_s += dt_s;
      });
  if (!reason.empty() || time_s <= 0) return;
  const Eigen::Vector3d measured_radps = angle_rad / time_s;
  bias_radps_ =
      bias_radps_ ? *bias_radps_ + kBiasWeight * (measured_radps - *bias_radps_) : measured_radps;
}

std::string ImuRotation::frame() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return frame_;
}

Eigen::Vector3d ImuRotation::bias_radps() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return bias_radps_.value_or(Eigen::Vector3d::Zero());
}

}  // namespace predictive_stereo
