#include "nodelets/odometry_input.h"

#include <sstream>

#include "nodelets/message_checks.h"
#include "nodelets/stereo_messages.h"
#include "nodelets/transforms.h"

namespace predictive_stereo {

void OdometryInput::start() {
  subscription_.replace(subscribe<nav_msgs::Odometry>(
      node_, health_, "odometry", 50, [this](const nav_msgs::OdometryConstPtr& odometry) {
        requireOdometry(*odometry);
        history_.add(odometry);
        silent_ = false;
        arrivals_.notify();
      }));
}

void OdometryInput::stop() {
  subscription_.shutdown();
  history_.clear();
  silent_ = false;
}

// Then the motion is not late: nobody publishes it.
bool OdometryInput::isAbsent(const std::string& camera) const {
  std::string error;
  return in_vain_ && !lookUpTransform(tf_.buffer, fixed_frame_, camera, *in_vain_, error);
}

template <class Ask>
auto OdometryInput::waitFor(const std_msgs::Header& now, const Ask& ask) {
  decltype(ask(nullptr)) answer;
  const double timeout_s = isAbsent(now.frame_id) ? 0 : timeout_s_;
  const bool complete = arrivals_.waitFor(timeout_s, [&] {
    const bool listen = subscription_.isPublished() && !silent_;
    answer = ask(listen ? &history_ : nullptr);
    return answer.complete;
  });
  if (answer.known() && !complete) silent_ = true;
  in_vain_.reset();
  if (!answer.known() && !complete) in_vain_ = now.stamp;
  return answer;
}

// The texts below are not those of tf, which contain stamps: a text that changes is logged every
// time.

std::optional<CameraMotion> OdometryInput::motion(ros::Time previous, const std_msgs::Header& now) {
  const MotionAnswer answer = waitFor(now, [&](const OdometryHistory* odometry) {
    return cameraMotion(tf_.buffer, odometry, now.frame_id, previous, now.stamp, fixed_frame_);
  });
  if (answer.motion) {
    health_.solved("motion");
    return answer.motion;
  }
  std::ostringstream missing;
  if (now.frame_id.empty())
    missing << kNoFrame << ": matched without prediction";
  else if (answer.complete)
    missing << answer.reason << ": matched without prediction";
  else
    missing << "tf has no motion of '" << now.frame_id << "' relative to odom_frame '"
            << fixed_frame_ << "' at the image's stamp within transform_timeout = " << timeout_s_
            << " s: matched without prediction. Run the EgoMotion nodelet with publish_tf, or set "
               "odom_frame to the fixed frame of your odometry";
  health_.problem("motion", Health::Severity::kDegraded, missing.str());
  return {};
}

std::optional<CameraPose> OdometryInput::pose(std::optional<ros::Time> previous,
                                              const std_msgs::Header& now) {
  const PoseAnswer answer = waitFor(now, [&](const OdometryHistory* odometry) {
    return cameraPose(tf_.buffer, odometry, now.frame_id, previous, now.stamp, fixed_frame_);
  });
  if (answer.pose) {
    health_.solved("pose");
    return answer.pose;
  }
  std::string missing;
  if (now.frame_id.empty())
    missing = std::string(kNoFrame) + ": no velocities";
  else if (answer.complete)
    missing = answer.reason + ": no velocities";
  else
    missing = "tf has no pose of '" + now.frame_id + "' in odom_frame '" + fixed_frame_ +
              "' at the image's stamp: no velocities. Run the EgoMotion nodelet with publish_tf, "
              "or set odom_frame to the fixed frame of your odometry";
  health_.problem("pose", Health::Severity::kDegraded, missing);
  return {};
}

}  // namespace predictive_stereo
