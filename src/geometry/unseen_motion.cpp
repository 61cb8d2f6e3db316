#include "predictive_stereo/unseen_motion.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {
namespace {

constexpr UnseenMotionModel kModel;
constexpr double kStep_s = 0.1, kLongestSpan_s = 60;
constexpr int kMostSteps = 40;  // of each phase of extrapolation

double squared(double value) { return value * value; }

// Translations first, then rotations.
Matrix6d perAxis(double translation, double rotation) {
  Vector6d diagonal;
  diagonal << Eigen::Vector3d::Constant(translation), Eigen::Vector3d::Constant(rotation);
  return diagonal.asDiagonal();
}

Matrix6d accelerationNoise() {
  return perAxis(squared(kModel.acceleration_noise), squared(kModel.turn_acceleration_noise));
}

// Pose and velocity with their joint covariance, while time passes.
struct Drift {
  Eigen::Isometry3d T_begin_now = Eigen::Isometry3d::Identity();
  Vector6d twist;
  // Of the pose's perturbation in its own frame, and of the twist.
  Matrix6d of_pose = Matrix6d::Zero(), of_pose_and_twist = Matrix6d::Zero(), of_twist;

  void pass(double span_s) {
    const int steps = std::min(kMostSteps, static_cast<int>(std::ceil(span_s / kStep_s)));
    for (int i = 0; i < steps; ++i) step(span_s / steps);
  }
  // T exp(e) exp((twist + v) h) = T exp(twist h) exp(A e + h v) for small e, v.
  void step(double h) {
    const Eigen::Isometry3d T_last_now = motionOf(twist, h);
    const Matrix6d A = adjoint(T_last_now.inverse()), q = accelerationNoise();
    const Matrix6d cross = A * of_pose_and_twist + h * of_twist;
    of_pose = A * of_pose * A.transpose() + h * of_pose_and_twist.transpose() * A.transpose() +
              h * cross.transpose() + h * h * h / 3 * q;
    of_pose = (of_pose + of_pose.transpose()).eval() / 2;
    of_pose_and_twist = cross + h * h / 2 * q;
    of_twist += h * q;
    T_begin_now = compose(T_begin_now, T_last_now);
  }
  // Rest is expected from here on, of the translation (first = 0) or of the rotation (3).
  void forgetTwist(int first) {
    const Eigen::Vector3d forgotten = twist.segment<3>(first);
    of_twist.block<3, 3>(first, first) += forgotten * forgotten.transpose();
    twist.segment<3>(first).setZero();
  }
};

}  // namespace

Velocity Velocity::unknown() {
  return {Vector6d::Zero(),
          perAxis(squared(kModel.unknown_speed_mps), squared(kModel.unknown_turn_rate_radps))};
}

// The motion measures the mean velocity. That at its end differs by what the noise adds. A motion
// between stamps that nearly coincide measures nothing: what is usual remains.
Velocity Velocity::after(const CameraMotion& motion, double dt_s) {
  const Velocity usual = unknown();
  const Matrix6d noise = motion.covariance / (dt_s * dt_s) + dt_s / 3 * accelerationNoise();
  const Matrix6d gain = usual.covariance * (usual.covariance + noise).inverse();
  const Matrix6d rest = Matrix6d::Identity() - gain;
  return {gain * constantTwist(motion.T_cam_prev.inverse(), dt_s),
          rest * usual.covariance * rest.transpose() + gain * noise * gain.transpose()};
}

CameraMotion unseenMotion(const Velocity& velocity, double span_s) {
  span_s = std::clamp(span_s, 0.0, kLongestSpan_s);
  const double turning_s = std::min(span_s, kModel.turning_s);
  const double moving_s = std::min(span_s, kModel.moving_s);
  Drift drift;
  drift.twist = velocity.twist;
  drift.of_twist = velocity.covariance;
  drift.pass(turning_s);
  drift.forgetTwist(3);
  drift.pass(moving_s - turning_s);
  drift.forgetTwist(0);
  drift.pass(span_s - moving_s);
  // A right perturbation of T_begin_now is a left one of its inverse.
  return {drift.T_begin_now.inverse(), drift.of_pose};
}

}  // namespace predictive_stereo
