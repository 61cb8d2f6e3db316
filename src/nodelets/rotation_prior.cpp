#include "nodelets/rotation_prior.h"

#include <cmath>

#include "nodelets/transforms.h"

namespace predictive_stereo {
namespace {

constexpr double kWithin_s = 0.05;
constexpr double kRest_mps = 0.02, kRest_radps = 0.005;

}  // namespace

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
  if (previous.isZero() || gap_s <= 0 || gap_s > params_.processor.max_gap) return {};
  if (params_.use_imu) return fromImu(previous, now);
  if (!params_.guess_frame.empty()) return fromTf(previous, now);
  return {};
}

std::optional<Eigen::Matrix3d> RotationPrior::fromImu(ros::Time previous,
                                                      const std_msgs::Header& now) {
  const std::string alone = "; ego-motion uses the images only";
  const auto fail = [&](const std::string& text) {
    health_.problem("imu", Health::Severity::kDegraded, text + alone);
    is_late_ = true;
    return std::nullopt;
  };
  const std::string topic = node_.resolveName("imu"), frame = imu_.frame();
  if (frame.empty() && !subscription_.isPublished())
    return fail("use_imu: nobody publishes " + topic + " (launch argument imu:=<topic>)");
  ImuRotation::Answer answer;
  arrivals_.waitFor(is_late_ ? 0 : kWithin_s, [&] {
    answer = imu_.between(previous, now.stamp);
    return answer.complete;
  });
  if (!answer.R_now_previous) return fail("use_imu: " + topic + ": " + answer.reason);
  std::string error;
  const auto T_cam_imu = lookUpTransform(tf_.buffer, now.frame_id, imu_.frame(), now.stamp, error);
  if (!T_cam_imu)
    return fail("use_imu: no transform from the left camera '" + now.frame_id +
                "' to the IMU's frame '" + imu_.frame() +
                "': publish it (e.g. by tf2_ros static_transform_publisher)");
  is_late_ = false;
  health_.solved("imu");
  const Eigen::Matrix3d R_cam_imu = T_cam_imu->linear();
  return R_cam_imu * *answer.R_now_previous * R_cam_imu.transpose();
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
    health_.problem("guess_frame", Health::Severity::kDegraded,
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
