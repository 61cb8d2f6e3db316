#pragma once

#include <ros/node_handle.h>
#include <sensor_msgs/Imu.h>
#include <std_msgs/Header.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "nodelets/message_input.h"
#include "nodelets/nodelet_params.h"
#include "nodelets/tf_input.h"
#include "nodelets/threads.h"
#include "nodelets/transforms.h"
#include "predictive_stereo/ego_motion.h"
#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {

/// Rotation of an IMU between two instants: integrates the angular velocities of its gyroscope,
/// interpolated linearly. Another thread may add measurements.
class ImuRotation {
 public:
  using History = MessageHistory<sensor_msgs::Imu>;

  /// @param history  must outlive this object.
  explicit ImuRotation(const History& history) : history_(history) {}

  /// R_now_previous, which maps directions from the IMU's axes at the first instant to those at the
  /// second one.
  Answer<Eigen::Matrix3d> between(ros::Time previous, ros::Time now) const {
    const Answer<Steps> steps = stepsBetween(previous, now);
    if (!steps.value) return {{}, steps.complete, steps.reason};
    Eigen::Matrix3d R_previous_now = Eigen::Matrix3d::Identity();
    for (const Step& step : *steps.value)
      R_previous_now =
          R_previous_now * rotationBy((step.mean_rate_radps - bias_radps_) * step.duration_s);
    return {R_previous_now.transpose(), true, ""};
  }

  /// Updates the bias with the mean angular velocity of an interval in which the camera did not
  /// move.
  void learnBias(ros::Time previous, ros::Time now) {
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
  const Eigen::Vector3d& bias_radps() const { return bias_radps_; }

  /// Frame of the measurements; empty: no measurements.
  std::string frame() const {
    const auto last = history_.last();
    return last ? last->header.frame_id : "";
  }

 private:
  static constexpr double kLargestGap_s = 0.1;  // between two measurements
  static constexpr double kBiasWeight = 0.1;    // of the newest interval; 1 for the first one
  static constexpr char kCure[] =
      ": stamp it by the clock of the images, and send it at 20 Hz or more";

  // Between two measurements, or a part of it at both ends of an interval.
  struct Step {
    Eigen::Vector3d mean_rate_radps;
    double duration_s;
  };
  using Steps = std::vector<Step>;

  Answer<Steps> stepsBetween(ros::Time previous, ros::Time now) const {
    const std::vector<sensor_msgs::ImuConstPtr> samples = history_.around(previous, now);
    const auto fail = [](bool complete, const std::string& reason) {
      return Answer<Steps>{{}, complete, reason};
    };
    // In sensor_msgs/Imu, -1 means that the device does not measure angular velocity.
    if (!samples.empty() && samples.back()->angular_velocity_covariance[0] == -1)
      return fail(true, "angular_velocity_covariance[0] is -1: it measures no angular velocity");
    if (samples.empty() || samples.back()->header.stamp < now)
      return fail(false, std::string("its last stamp is before the image's") + kCure);
    if (samples.front()->header.stamp > previous)
      return fail(
          true, std::string("its stamps begin after the previous image's, or jumped back") + kCure);
    Steps steps;
    for (size_t i = 1; i < samples.size(); ++i) {
      const sensor_msgs::Imu &before = *samples[i - 1], &after = *samples[i];
      const double begin_s = std::max(0.0, (previous - before.header.stamp).toSec());
      const double length_s = (after.header.stamp - before.header.stamp).toSec();
      const double end_s = std::min(length_s, (now - before.header.stamp).toSec());
      if (end_s <= begin_s) continue;  // a measurement that came twice
      if (length_s > kLargestGap_s)
        return fail(true, cv::format("its stamps jump by %.2f s", length_s) + kCure);
      const double middle = (begin_s + end_s) / 2 / length_s;  // linear interpolation
      const Eigen::Vector3d rate = rate_radps(before);
      steps.push_back({rate + middle * (rate_radps(after) - rate), end_s - begin_s});
    }
    return {steps, true, ""};
  }

  static Eigen::Vector3d rate_radps(const sensor_msgs::Imu& imu) {
    return {imu.angular_velocity.x, imu.angular_velocity.y, imu.angular_velocity.z};
  }

  const History& history_;
  Eigen::Vector3d bias_radps_ = Eigen::Vector3d::Zero();
  bool knows_bias_ = false;
};

/// The camera's rotation since the previous frame from another sensor: an IMU (use_imu) or another
/// odometry in tf (guess_frame).
class RotationInput {
 public:
  RotationInput(const ros::NodeHandle& node, Health& health, Arrivals& arrivals, TfInput& tf,
                const EgoMotionNodeletParams& params)
      : topic_(node.resolveName("imu")),
        health_(health),
        arrivals_(arrivals),
        tf_(tf),
        params_(params),
        input_(node, health, arrivals) {}

  void start() {
    if (params_.use_imu) input_.listenTo("imu", 500);
  }
  /// After this has returned, nothing is received.
  void stop() { input_.listenTo(""); }

  /// @param previous  zero: there is no previous frame.
  std::optional<Eigen::Matrix3d> since(ros::Time previous, const std_msgs::Header& now) {
    const double gap_s = (now.stamp - previous).toSec();
    if (previous.isZero() || gap_s <= 0 || gap_s > params_.max_gap) return {};
    if (params_.use_imu) return fromImu(previous, now);
    if (!params_.guess_frame.empty()) return fromTf(previous, now);
    return {};
  }

  /// At rest a gyroscope measures its bias.
  void learnBias(ros::Time previous, ros::Time now, const EgoMotionEstimate& estimate) {
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

 private:
  static constexpr double kWithin_s = 0.05;
  static constexpr double kRest_mps = 0.02, kRest_radps = 0.005;

  std::optional<Eigen::Matrix3d> fromImu(ros::Time previous, const std_msgs::Header& now) {
    if (imu_.frame().empty() && !input_.isPublished())
      return fail("imu", "use_imu: nobody publishes sensor_msgs/Imu on " + topic_ +
                             " (launch argument imu:=<topic>)");
    Answer<Eigen::Matrix3d> answer;
    const sensor_msgs::ImuConstPtr newest = input_.history().last();
    const ros::Time newest_stamp = newest ? newest->header.stamp : ros::Time();
    arrivals_.waitFor(patience_s(now.stamp, newest_stamp), [&] {
      answer = imu_.between(previous, now.stamp);
      return answer.complete;
    });
    if (!answer.value) return fail("imu", "use_imu: " + topic_ + ": " + answer.reason);
    std::string error;
    const auto T_cam_imu =
        lookUpTransform(tf_.buffer, now.frame_id, imu_.frame(), now.stamp, error);
    if (!T_cam_imu)
      return fail("imu", "use_imu: no transform from the left camera '" + now.frame_id +
                             "' to the IMU's frame '" + imu_.frame() +
                             "': publish it (e.g. by tf2_ros static_transform_publisher)");
    is_late_ = false;
    health_.solved("imu");
    const Eigen::Matrix3d R_cam_imu = T_cam_imu->linear();
    return R_cam_imu * *answer.value * R_cam_imu.transpose();
  }

  std::optional<Eigen::Matrix3d> fromTf(ros::Time previous, const std_msgs::Header& now) {
    std::string error;
    const ros::Time newest = newestPose(tf_.buffer, params_.guess_frame, now.frame_id);
    const auto T_cam_prev = arrivals_.waitFor(patience_s(now.stamp, newest), [&] {
      return lookUpCameraMotion(tf_.buffer, now.frame_id, previous, now.stamp, params_.guess_frame,
                                error);
    });
    if (!T_cam_prev)  // Not the text of tf, which contains stamps: each would be logged.
      return fail("guess_frame",
                  "tf has no motion of '" + now.frame_id + "' relative to guess_frame '" +
                      params_.guess_frame + "' at the image's stamp: " +
                      (isLate(tf_.buffer, params_.guess_frame, now.frame_id, now.stamp)
                           ? "it is too late to be used; send it earlier, or correct its stamps"
                           : "set guess_frame to the fixed frame of another odometry, or leave it "
                             "empty"));
    is_late_ = false;
    health_.solved("guess_frame");
    return Eigen::Matrix3d(T_cam_prev->linear());
  }

  // Not for what was too late already, unless it has become almost as new as the image.
  double patience_s(ros::Time image, ros::Time newest) const {
    return is_late_ && (image - newest).toSec() > kWithin_s ? 0 : kWithin_s;
  }

  std::nullopt_t fail(const std::string& cause, const std::string& text) {
    health_.problem(cause, text + "; ego-motion uses the images only");
    is_late_ = true;
    return std::nullopt;
  }

  const std::string topic_;
  Health& health_;
  Arrivals& arrivals_;
  TfInput& tf_;
  const EgoMotionNodeletParams& params_;
  MessageInput<sensor_msgs::Imu> input_;
  ImuRotation imu_{input_.history()};
  bool is_late_ = false;  // the last frame got nothing
};

}  // namespace predictive_stereo
