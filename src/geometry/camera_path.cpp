#include "predictive_stereo/camera_path.h"

#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {

void CameraPath::add(const EgoMotionEstimate& estimate, Stamp stamp,
                     const Eigen::Isometry3d& T_body_cam) {
  motion_start_.reset();
  pose_.velocity.reset();
  if (!last_known_) {
    recent_ = {Frame{stamp, compose(origin_, T_body_cam), origin_, PathCovariance()}};
    last_known_ = recent_.back();
    pose_ = PoseEstimate();
    pose_.state = PoseState::kKnown;
    pose_.T_odom_cam = recent_.back().T_odom_cam;
    pose_.T_odom_body = origin_;
    return;
  }
  if (const Frame* const start = startOf(estimate)) {
    motion_start_ = start->stamp;
    const double dt_s = toSeconds(stamp - start->stamp);
    const Frame from = *start;
    append(from, estimate.motion, estimate.common_errors, stamp, T_body_cam);
    const Matrix6d A = adjoint(T_body_cam);
    const Matrix6d step = A * estimate.motion.covariance * A.transpose();
    pose_.state = PoseState::kKnown;
    pose_.motion_covariance =
        from.stamp <= last_known_->stamp ? estimate.motion.covariance : unseenCovariance();
    pose_.velocity = Velocity{constantTwist(relative(from.T_odom_body, pose_.T_odom_body), dt_s),
                              step / (dt_s * dt_s)};
    velocity_ = Velocity::after(estimate.motion, dt_s);
    last_known_ = recent_.back();
    recent_ = {*last_known_};
    return;
  }
  const double unseen_s = toSeconds(stamp - last_known_->stamp);
  append(*last_known_, unseenMotion(velocity_, unseen_s), CommonErrors::Zero(), stamp, T_body_cam);
  pose_.state = estimate.state == PoseState::kHeld ? PoseState::kHeld : PoseState::kLost;
  pose_.motion_covariance = unseenCovariance();
  if (recent_.size() > EgoMotionEstimate::kMostFrames) recent_.pop_front();
}

const CameraPath::Frame* CameraPath::startOf(const EgoMotionEstimate& estimate) const {
  const auto frames = static_cast<size_t>(estimate.frames);
  if (estimate.state != PoseState::kKnown || frames > recent_.size()) return nullptr;
  return &recent_[recent_.size() - frames];
}

void CameraPath::append(const Frame& from, const CameraMotion& motion, const CommonErrors& common,
                        Stamp stamp, const Eigen::Isometry3d& T_body_cam) {
  Frame frame;
  frame.stamp = stamp;
  frame.T_odom_cam = compose(from.T_odom_cam, motion.T_cam_prev.inverse());
  frame.T_odom_body = compose(frame.T_odom_cam, T_body_cam.inverse());
  // A left perturbation of T_cam_prev is a right perturbation of the camera's pose.
  const Eigen::Isometry3d T_prev_body = relative(from.T_odom_body, frame.T_odom_body);
  const Matrix6d A = adjoint(T_body_cam);
  frame.covariance = from.covariance;
  frame.covariance.add({T_prev_body.inverse(), A * motion.covariance * A.transpose()}, A * common);
  recent_.push_back(frame);
  pose_.T_odom_cam = frame.T_odom_cam;
  pose_.T_odom_body = frame.T_odom_body;
  pose_.covariance = frame.covariance.covariance();
}

}  // namespace predictive_stereo
