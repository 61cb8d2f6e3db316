#include "nodelets/motion_source.h"

#include "nodelets/transforms.h"

namespace predictive_stereo {
namespace {

// Odometry this much later than a frame does not belong to it.
bool isTooNew(const nav_msgs::Odometry& odometry, ros::Time frame) {
  return odometry.header.stamp - frame > ros::Duration(0.1);
}

}  // namespace

MotionAnswer cameraMotion(const tf2::BufferCore& tf, const OdometryHistory* odometry,
                          const std::string& camera, ros::Time previous, ros::Time now,
                          const std::string& fixed_frame) {
  MotionAnswer answer;
  const auto T_cam_prev = lookUpCameraMotion(tf, camera, previous, now, fixed_frame, answer.reason);
  if (!T_cam_prev) return answer;
  answer.motion = CameraMotion{*T_cam_prev, Matrix6d::Zero()};
  answer.complete = !odometry;
  if (!odometry) return answer;

  const nav_msgs::OdometryConstPtr odometry_now = odometry->at(now);
  const nav_msgs::OdometryConstPtr odometry_previous = odometry->at(previous);
  if (!odometry_now) return answer;
  answer.complete = true;
  if (isTooNew(*odometry_now, now)) return answer;
  const bool was_lost = odometry_previous && !isTooNew(*odometry_previous, previous) &&
                        poseIsUnknown(*odometry_previous);
  if (twistIsUnknown(*odometry_now) || was_lost) {
    answer.motion.reset();
    answer.reason = "the odometry is lost";
    return answer;
  }
  if (const auto T_cam_child =
          lookUpTransform(tf, camera, odometry_now->child_frame_id, now, answer.reason))
    answer.motion->covariance =
        motionCovariance(*odometry_now, (now - previous).toSec(), *T_cam_child);
  return answer;
}

}  // namespace predictive_stereo
