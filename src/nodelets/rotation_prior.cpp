#include "nodelets/rotation_prior.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {
namespace {

constexpr char kCure[] = ": stamp it by the clock of the images, and send it at 20 Hz or more";

constexpr double kWithin_s = 0.05;
constexpr double kRest_mps = 0.02, kRest_radps = 0.005;

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

Answer<Eigen::Matrix3d> ImuRotation::between(ros::Time previous, ros::Time now) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  Answer<Eigen::Matrix3d> answer;
  const Eigen::Vector3d bias = bias_radps_.value_or(Eigen::Vector3d::Zero());
  Eigen::Matrix3d R_previous_now = Eigen::Matrix3d::Identity();
  answer.reason = forEachStep(
      previous, now, answer.complete, [&](const Eigen::Vector3d& rate_radps, double dt_s) {
        R_previous_now = R_previous_now * rotationBy((rate_radps - bias) * dt_s);
      });
  if (answer.reason.empty()) answer.value = R_previous_now.transpose();
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

void RotationPrior::start() {
  if (!params_.use_imu) return;
  subscription_.replace(subscribe<sensor_msgs::Imu>(node_, health_, "imu", 500,
                                                    [this](const sensor_msgs::ImuConstPtr& imu) {
                                                      requireImu(*imu);
                                                      imu_.add(imu);
                                                      arrivals_.notify();
                                                    }));
}

std::optional<Eigen::Matrix3d> RotationPrior::since(ros::Time previous,
                                                    const std_msgs::Header& now) {
  const double gap_s = (now.stamp - previous).toSec();
  if (previous.isZero() || gap_s <= 0 || gap_s > params_.max_gap) return {};
  if (params_.use_imu) return fromImu(previous, now);
  if (!params_.guess_frame.empty()) return fromTf(previous, now);
  return {};
}

std::optional<Eigen::Matrix3d> RotationPrior::fromImu(ros::Time previous,
                                                      const std_msgs::Header& now) {
  const std::string alone = "; ego-motion uses the images only";
  const auto fail = [&](const std::string& text) {
    health_.problem("imu", text + alone);
    is_late_ = true;
    return std::nullopt;
  };
  const std::string topic = node_.resolveName("imu"), frame = imu_.frame();
  if (frame.empty() && !subscription_.isPublished())
    return fail("use_imu: nobody publishes " + topic + " (launch argument imu:=<topic>)");
  Answer<Eigen::Matrix3d> answer;
  arrivals_.waitFor(is_late_ ? 0 : kWithin_s, [&] {
    answer = imu_.between(previous, now.stamp);
    return answer.complete;
  });
  if (!answer.value) return fail("use_imu: " + topic + ": " + answer.reason);
  std::string error;
  const auto T_cam_imu = lookUpTransform(tf_.buffer, now.frame_id, imu_.frame(), now.stamp, error);
  if (!T_cam_imu)
    return fail("use_imu: no transform from the left camera '" + now.frame_id +
                "' to the IMU's frame '" + imu_.frame() +
                "': publish it (e.g. by tf2_ros static_transform_publisher)");
  is_late_ = false;
  health_.solved("imu");
  const Eigen::Matrix3d R_cam_imu = T_cam_imu->linear();
  return R_cam_imu * *answer.value * R_cam_imu.transpose();
}

std::optional<Eigen::Matrix3d> RotationPrior::fromTf(ros::Time previous,
                                                     const std_msgs::Header& now) {
  std::string error;
  const auto T_cam_prev = arrivals_.waitFor(is_late_ ? 0 : kWithin_s, [&] {
    return lookUpCameraMotion(tf_.buffer, now.frame_id, previous, now.stamp, params_.guess_frame,
                              error);
  });
  is_late_ = !T_cam_prev;
  if (!T_cam_prev) {
    // Not the text of tf, which contains stamps: a text that changes is logged every time.
    health_.problem("guess_frame",
                    "tf has no motion of '" + now.frame_id + "' relative to guess_frame '" +
                        params_.guess_frame +
                        "' at the image's stamp: set guess_frame to the fixed frame of another "
                        "odometry, or leave it empty; ego-motion uses the images only");
    return std::nullopt;
  }
  health_.solved("guess_frame");
  return Eigen::Matrix3d(T_cam_prev->linear());
}

void RotationPrior::learnBias(ros::Time previous, ros::Time now,
                              const EgoMotionEstimate& estimate) {
  const double dt_s = (now - previous).toSec();
  if (!params_.use_imu || previous.isZero() || dt_s <= 0 || estimate.state != PoseState::kKnown ||
      estimate.frames != 1)
    return;
  const Eigen::Isometry3d& T = estimate.motion.T_cam_prev;
  if (T.translation().norm() > kRest_mps * dt_s ||
      Eigen::AngleAxisd(T.linear()).angle() > kRest_radps * dt_s)
    return;
  imu_.learnBias(previous, now);
  health_.figure("gyro bias [deg/s]", imu_.bias_radps().norm() * 180 / M_PI, "%.3f");
}

}  // namespace predictive_stereo
