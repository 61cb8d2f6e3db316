#include "nodelets/rotation_prior.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {
namespace {

constexpr char kCure[] = ": stamp it by the clock of the images, and send it at 20 Hz or more";

constexpr double kWithin_s = 0.05;
constexpr double kRest_mps = 0.02, kRest_radps = 0.005;

Eigen::Vector3d rate_radps(const sensor_msgs::Imu& imu) {
  return {imu.angular_velocity.x, imu.angular_velocity.y, imu.angular_velocity.z};
}

}  // namespace

Answer<ImuRotation::Steps> ImuRotation::stepsBetween(ros::Time previous, ros::Time now) const {
  const std::vector<sensor_msgs::ImuConstPtr> samples = history_.around(previous, now);
  // In sensor_msgs/Imu, -1 means that the device does not measure angular velocity.
  if (!samples.empty() && samples.back()->angular_velocity_covariance[0] == -1)
    return {{}, true, "angular_velocity_covariance[0] is -1: it measures no angular velocity"};
  if (samples.empty() || samples.back()->header.stamp < now)
    return {{}, false, std::string("its last stamp is before the image's") + kCure};
  if (samples.front()->header.stamp > previous)
    return {{},
            true,
            std::string("its stamps begin after the previous image's, or jumped back") + kCure};
  Steps steps;
  for (size_t i = 1; i < samples.size(); ++i) {
    const sensor_msgs::Imu &before = *samples[i - 1], &after = *samples[i];
    const double begin_s = std::max(0.0, (previous - before.header.stamp).toSec());
    const double length_s = (after.header.stamp - before.header.stamp).toSec();
    const double end_s = std::min(length_s, (now - before.header.stamp).toSec());
    if (end_s <= begin_s) continue;  // a measurement that came twice
    if (length_s > kLargestGap_s) {
      char text[100];
      std::snprintf(text, sizeof(text), "its stamps jump by %.2f s", length_s);
      return {{}, true, std::string(text) + kCure};
    }
    const double middle = (begin_s + end_s) / 2 / length_s;  // linear interpolation
    const Eigen::Vector3d rate = rate_radps(before);
    steps.push_back({rate + middle * (rate_radps(after) - rate), end_s - begin_s});
  }
  return {steps, true, ""};
}

Answer<Eigen::Matrix3d> ImuRotation::between(ros::Time previous, ros::Time now) const {
  const Answer<Steps> steps = stepsBetween(previous, now);
  if (!steps.value) return {{}, steps.complete, steps.reason};
  Eigen::Matrix3d R_previous_now = Eigen::Matrix3d::Identity();
  for (const Step& step : *steps.value)
    R_previous_now =
        R_previous_now * rotationBy((step.mean_rate_radps - bias_radps_) * step.duration_s);
  return {R_previous_now.transpose(), true, ""};
}

void ImuRotation::learnBias(ros::Time previous, ros::Time now) {
  const Answer<Steps> steps = stepsBetween(previous, now);
  Eigen::Vector3d angle_rad = Eigen::Vector3d::Zero();
  double time_s = 0;
  for (const Step& step : steps.value.value_or(Steps())) {
    angle_rad += step.mean_rate_radps * step.duration_s;
    time_s += step.duration_s;
  }
  if (time_s <= 0) return;
  const double weight = std::exchange(knows_bias_, true) ? kBiasWeight : 1;
  bias_radps_ += weight * (angle_rad / time_s - bias_radps_);
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
