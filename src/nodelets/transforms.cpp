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
constexpr double kRounding = 1e-6;  // of motions [m, rad]

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

// A path begins with the first frame, to which there is no motion.
bool isFirst(const nav_msgs::Odometry& odometry) {
  return fromMsg(odometry.pose.covariance).isZero();
}

// Whether the odometry did not see the motion to one of the frames from `previous` until before
// `now`. Where a path begins there is none to see, but the pose has jumped there since `previous`.
bool wasUnseen(const OdometryHistory& odometry, ros::Time previous, ros::Time now) {
  for (auto message = odometry.before(now); message && message->header.stamp >= previous;
       message = odometry.before(message->header.stamp))
    if (twistIsUnknown(*message) && !(isFirst(*message) && message->header.stamp == previous))
      return true;
  return false;
}

// Whether the twist explains a motion in tf [m, rad]. After a loss it is the mean since the frame
// that the camera was compared with: a motion that begins before this one has a part that was not
// seen.
bool explains(const nav_msgs::Odometry& odometry, const Vector6d& motion, double dt_s) {
  Vector6d twist;
  tf2::fromMsg(odometry.twist.twist, twist);
  const Vector6d off = motion - dt_s * twist;
  const Vector6d sigma = dt_s * fromMsg(odometry.twist.covariance).diagonal().cwiseSqrt();
  return (off.cwiseAbs().array() <= 3 * sigma.array() + kRounding).all();
}

// None: it has a twist only, or is damaged.
std::optional<Eigen::Isometry3d> poseOf(const nav_msgs::Odometry& odometry) {
  const geometry_msgs::Pose& pose = odometry.pose.pose;
  const auto& q = pose.orientation;
  Eigen::Isometry3d T;
  tf2::fromMsg(pose, T);
  const bool is_pose = std::abs(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w - 1) < 0.01;
  return is_pose && T.matrix().allFinite() ? std::optional(T) : std::nullopt;
}

// By how much the poses of the odometry say another motion than tf [m, rad]; zero if it has none of
// these frames.
Vector6d differenceFromPoses(const OdometryHistory& odometry,
                             const nav_msgs::Odometry& odometry_now, ros::Time previous,
                             ros::Time now, const Vector6d& motion) {
  const auto before = odometry.of(previous);
  if (!before || odometry_now.header.stamp != now) return Vector6d::Zero();
  const auto T_odom_prev = poseOf(*before), T_odom_now = poseOf(odometry_now);
  if (!T_odom_prev || !T_odom_now) return Vector6d::Zero();
  const double dt_s = (now - previous).toSec();
  return dt_s * constantTwist(relative(*T_odom_prev, *T_odom_now), dt_s) - motion;
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
  return found(
      [&] { return tf.lookupTransform(withoutSlash(target), withoutSlash(source), stamp); }, error);
}

std::string doubtAboutMount(const Eigen::Isometry3d& T_base_cam, const std::string& base,
                            const std::string& camera) {
  constexpr double kSteep = 0.8;       // more than 53 degrees above the horizon
  constexpr double kUpsideDown = 0.5;  // its y axis more than 30 degrees above it
  const Eigen::Matrix3d R_base_cam = T_base_cam.linear();
  if (withoutSlash(base) == withoutSlash(camera)) return "";
  const std::string name = "by tf the left camera '" + camera + "' ";
  if (R_base_cam(2, 2) > kSteep)
    return name + "looks up from '" + base + "'. If it does not, '" + camera +
           "' is not its optical frame (z ahead, y down): correct the frame_id of the images, or "
           "this transform";
  if (R_base_cam(2, 1) > kUpsideDown)
    return name + "is upside down in '" + base +
           "': most people are not found. Turn both images by 180 degrees, and swap left and right";
  return "";
}

std::optional<Eigen::Isometry3d> lookUpCameraMotion(const tf2::BufferCore& tf,
                                                    const std::string& camera, ros::Time previous,
                                                    ros::Time now, const std::string& fixed_frame,
                                                    std::string& error) {
  const std::string frame = withoutSlash(camera), fixed = withoutSlash(fixed_frame);
  return found([&] { return tf.lookupTransform(frame, now, frame, previous, fixed); }, error);
}

bool twistIsUnknown(const nav_msgs::Odometry& odometry) {
  return fromMsg(odometry.twist.covariance).diagonal().minCoeff() >= kUnknownCovariance;
}

Matrix6d motionCovariance(const nav_msgs::Odometry& odometry, double dt_s,
                          const Eigen::Isometry3d& T_cam_child) {
  Matrix6d motion = fromMsg(odometry.twist.covariance) * (dt_s * dt_s);
  if (!motion.allFinite() || motion.diagonal().minCoeff() < 0) return Matrix6d::Zero();
  int told = 0;
  for (int axis = 0; axis < 6; ++axis) {
    const double variance = odometry.twist.covariance[static_cast<size_t>(7 * axis)];
    if (variance > 0 && variance < kUnknownCovariance) {
      ++told;
      continue;
    }
    motion.row(axis).setZero();
    motion.col(axis).setZero();
    motion(axis, axis) = untoldCovariance()(axis, axis);
  }
  if (told == 0) return Matrix6d::Zero();
  const Matrix6d A = adjoint(T_cam_child);
  return A * motion * A.transpose();
}

MotionAnswer cameraMotion(const tf2::BufferCore& tf, const OdometryHistory* odometry,
                          const std::string& camera, ros::Time previous, ros::Time now,
                          const std::string& fixed_frame) {
  std::string error;
  // Asked first, because tf receives poses meanwhile.
  const bool has_now = lookUpTransform(tf, fixed_frame, camera, now, error).has_value();
  const auto T_cam_prev = lookUpCameraMotion(tf, camera, previous, now, fixed_frame, error);
  // What tf lacks before a pose that it has will not come any more.
  if (!T_cam_prev)
    return {std::nullopt, has_now, has_now ? "tf has no pose of the frame before" : error};
  MotionAnswer answer{CameraMotion{*T_cam_prev, Matrix6d::Zero()}, false, ""};
  const auto odometry_now = odometryOf(now, odometry, answer.complete);
  if (!odometry_now) return answer;
  const double dt_s = (now - previous).toSec();
  const std::string& child = odometry_now->child_frame_id;
  std::optional<Vector6d> motion;  // of the child
  if (const auto T_child_prev = lookUpCameraMotion(tf, child, previous, now, fixed_frame, error))
    motion = dt_s * constantTwist(T_child_prev->inverse(), dt_s);
  const Vector6d off = motion
                           ? differenceFromPoses(*odometry, *odometry_now, previous, now, *motion)
                           : Vector6d::Zero();
  const bool is_of_tf = off.isZero(kRounding);
  const auto isLost = [&] {
    if (twistIsUnknown(*odometry_now)) return true;
    return wasUnseen(*odometry, previous, now) &&
           !(motion && explains(*odometry_now, *motion, dt_s));
  };
  if (is_of_tf && isLost()) return {std::nullopt, true, kLost};
  const auto T_cam_child = lookUpTransform(tf, camera, child, now, error);
  if (!T_cam_child) {
    answer.reason = "child_frame_id '" + child + "' of odometry has no transform to '" + camera +
                    "' in tf: the covariance of the motion is unknown";
    return answer;
  }
  answer.value->covariance = motionCovariance(*odometry_now, dt_s, *T_cam_child);
  if (is_of_tf || answer.value->covariance.isZero()) return answer;
  const Vector6d of_camera = adjoint(*T_cam_child) * off;
  answer.value->covariance += of_camera * of_camera.transpose();
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
  const MotionAnswer since = cameraMotion(tf, odometry, camera, *previous, now, fixed_frame);
  if (!since.value && twistIsUnknown(*odometry_now)) return {std::nullopt, true, kLost};
  if (since.value) answer.reason = since.reason;
  answer.value->motion_covariance = since.value ? since.value->covariance : unseenCovariance();
  return answer;
}

}  // namespace predictive_stereo
