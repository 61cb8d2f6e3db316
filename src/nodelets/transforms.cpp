#include "nodelets/transforms.h"

#include <tf2/exceptions.h>
#include <tf2_eigen/tf2_eigen.h>

#include <cmath>

namespace predictive_stereo {
namespace {

double rounded(double value) {
  constexpr double kUnit = 1.0 / 4294967296.0;  // 2^-32
  return std::round(value / kUnit) * kUnit;
}

Eigen::Isometry3d rounded(const Eigen::Isometry3d& T) {
  Eigen::Quaterniond q(T.linear());
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  q.coeffs() = q.coeffs().unaryExpr([](double c) { return rounded(c); });
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  result.linear() = q.normalized().toRotationMatrix();
  result.translation() = T.translation().unaryExpr([](double c) { return rounded(c); });
  return result;
}

// What `look_up` finds in tf, rounded.
template <class LookUp>
std::optional<Eigen::Isometry3d> found(const LookUp& look_up, std::string& error) {
  try {
    const Eigen::Isometry3d T = fromMsg(look_up().transform);
    if (T.matrix().allFinite()) return rounded(T);
    // tf2 refuses values that are not finite, but its interpolation of huge ones can overflow.
    error = "the transform in tf is not finite: check its publisher";
  } catch (const tf2::TransformException& e) {
    error = e.what();
  }
  return std::nullopt;
}

constexpr char kLost[] = "the odometry is lost";

// Odometry this much later than a frame does not belong to it.
bool isTooNew(const nav_msgs::Odometry& odometry, ros::Time frame) {
  return odometry.header.stamp - frame > ros::Duration(0.1);
}

// The odometry of this frame; nullptr: there is none.
// @param complete  waiting longer does not help.
nav_msgs::OdometryConstPtr odometryOf(ros::Time frame, const OdometryHistory* odometry,
                                      bool& complete) {
  const nav_msgs::OdometryConstPtr found = odometry ? odometry->at(frame) : nullptr;
  complete = !odometry || found;
  return found && !isTooNew(*found, frame) ? found : nullptr;
}

// Whether the odometry did not see the motion to one of the frames from `previous` until before
// `now`. (To the first frame of a path there is none.)
bool wasUnseen(const OdometryHistory& odometry, ros::Time previous, ros::Time now) {
  for (auto message = odometry.before(now); message && message->header.stamp >= previous;
       message = odometry.before(message->header.stamp))
    if (twistIsUnknown(*message)) return true;
  return false;
}

// Whether the twist explains a motion in tf. After a loss it is the mean since the frame that the
// camera was compared with: a motion that begins before this one has a part that was not seen.
bool explains(const nav_msgs::Odometry& odometry, const Eigen::Isometry3d& T_prev_now,
              double dt_s) {
  constexpr double kRounding = 1e-6;
  Vector6d twist;
  tf2::fromMsg(odometry.twist.twist, twist);
  const Vector6d off = dt_s * (constantTwist(T_prev_now, dt_s) - twist);
  const Vector6d sigma = dt_s * fromMsg(odometry.twist.covariance).diagonal().cwiseSqrt();
  return (off.cwiseAbs().array() <= 3 * sigma.array() + kRounding).all();
}

}  // namespace

Eigen::Isometry3d fromMsg(const geometry_msgs::Transform& message) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::Quaterniond(message.rotation.w, message.rotation.x, message.rotation.y,
                                  message.rotation.z)
                   .normalized()
                   .toRotationMatrix();
  T.translation() << message.translation.x, message.translation.y, message.translation.z;
  return T;
}

geometry_msgs::TransformStamped transformMsg(ros::Time stamp, const std::string& parent,
                                             const std::string& child,
                                             const Eigen::Isometry3d& T_parent_child) {
  geometry_msgs::TransformStamped message = tf2::eigenToTransform(T_parent_child);
  message.header.stamp = stamp;
  message.header.frame_id = parent;
  message.child_frame_id = child;
  return message;
}

Matrix6d fromMsg(const boost::array<double, 36>& covariance) {
  return Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(covariance.data());
}

boost::array<double, 36> covarianceMsg(const Matrix6d& covariance) {
  boost::array<double, 36> message;
  Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(message.data()) = covariance;
  return message;
}

std::optional<Eigen::Isometry3d> lookUpTransform(const tf2::BufferCore& tf,
                                                 const std::string& target,
                                                 const std::string& source, ros::Time stamp,
                                                 std::string& error) {
  return found([&] { return tf.lookupTransform(target, source, stamp); }, error);
}

std::optional<Eigen::Isometry3d> lookUpCameraMotion(const tf2::BufferCore& tf,
                                                    const std::string& camera, ros::Time previous,
                                                    ros::Time now, const std::string& fixed_frame,
                                                    std::string& error) {
  return found([&] { return tf.lookupTransform(camera, now, camera, previous, fixed_frame); },
               error);
}

bool twistIsUnknown(const nav_msgs::Odometry& odometry) {
  return fromMsg(odometry.twist.covariance).diagonal().minCoeff() >= kUnknownCovariance;
}

Matrix6d motionCovariance(const nav_msgs::Odometry& odometry, double dt_s,
                          const Eigen::Isometry3d& T_cam_child) {
  const Matrix6d twist = fromMsg(odometry.twist.covariance);
  const Vector6d variances = twist.diagonal();
  // Wheel odometry has huge variances for axes that it does not measure.
  if (!twist.allFinite() || variances.minCoeff() < 0 || variances.maxCoeff() >= kUnknownCovariance)
    return Matrix6d::Zero();
  const Matrix6d A = adjoint(T_cam_child);
  return A * twist * A.transpose() * (dt_s * dt_s);
}

MotionAnswer cameraMotion(const tf2::BufferCore& tf, const OdometryHistory* odometry,
                          const std::string& camera, ros::Time previous, ros::Time now,
                          const std::string& fixed_frame) {
  MotionAnswer answer;
  const auto T_cam_prev = lookUpCameraMotion(tf, camera, previous, now, fixed_frame, answer.reason);
  if (!T_cam_prev) return answer;
  answer.value = CameraMotion{*T_cam_prev, Matrix6d::Zero()};
  const auto odometry_now = odometryOf(now, odometry, answer.complete);
  if (!odometry_now) return answer;
  const double dt_s = (now - previous).toSec();
  bool seen = !twistIsUnknown(*odometry_now);
  if (seen && wasUnseen(*odometry, previous, now)) {
    const auto T_now_prev = lookUpCameraMotion(tf, odometry_now->child_frame_id, previous, now,
                                               fixed_frame, answer.reason);
    seen = T_now_prev && explains(*odometry_now, T_now_prev->inverse(), dt_s);
  }
  if (!seen) return {std::nullopt, true, kLost};
  if (const auto T_cam_child =
          lookUpTransform(tf, camera, odometry_now->child_frame_id, now, answer.reason))
    answer.value->covariance = motionCovariance(*odometry_now, dt_s, *T_cam_child);
  return answer;
}

PoseAnswer cameraPose(const tf2::BufferCore& tf, const OdometryHistory* odometry,
                      const std::string& camera, std::optional<ros::Time> previous, ros::Time now,
                      const std::string& fixed_frame) {
  if (previous && *previous >= now) previous.reset();
  PoseAnswer answer;
  const auto T_odom_cam = lookUpTransform(tf, fixed_frame, camera, now, answer.reason);
  if (!T_odom_cam) return answer;
  answer.value = CameraPose{*T_odom_cam, Matrix6d::Zero()};
  const auto odometry_now = odometryOf(now, odometry, answer.complete);
  if (!odometry_now || !previous) return answer;  // the first pose of a path has no twist
  if (twistIsUnknown(*odometry_now)) return {std::nullopt, true, kLost};
  const MotionAnswer since = cameraMotion(tf, odometry, camera, *previous, now, fixed_frame);
  answer.value->motion_covariance = since.value ? since.value->covariance : unseenCovariance();
  return answer;
}

}  // namespace predictive_stereo
