/// The motion of a camera while nobody sees it: a velocity that becomes more and more uncertain.
#pragma once

#include "predictive_stereo/disparity_motion.h"

namespace predictive_stereo {

/// Constant velocity with white noise as acceleration. After a time t without a view, the standard
/// deviation of the velocity has grown to noise * sqrt(t), that of the position to
/// noise * sqrt(t^3 / 3); turns add to the position what the way travelled makes of them.
///
/// One set for cars, robots, drones and hands: an emergency brake and a shaken hand are within
/// three sigma, so a car on a straight road gets far more than it needs (docs/design_notes.md).
struct UnseenMotionModel {
  double acceleration_noise = 2.5;       ///< per axis [m/s^2 / sqrt(Hz)]
  double turn_acceleration_noise = 1.0;  ///< per axis [rad/s^2 / sqrt(Hz)]
  /// Standard deviations per axis of velocities, before one is measured.
  double unknown_speed_mps = 10, unknown_turn_rate_radps = 1;
  /// For these times the last velocity and turn rate predict the pose better than rest does. Then
  /// rest is expected, and what was the velocity becomes a part of its uncertainty.
  double moving_s = 5, turning_s = 1;
};

/// Velocity of a body in its own frame.
struct Velocity {
  Vector6d twist = Vector6d::Zero();       ///< linear [m/s], angular [rad/s]
  Matrix6d covariance = Matrix6d::Zero();  ///< [m^2/s^2], [rad^2/s^2]

  /// One that was never measured.
  static Velocity unknown();
  /// At the end of a motion that took dt_s > 0.
  static Velocity after(const CameraMotion& motion, double dt_s);
};

/// The motion that nobody saw.
/// @param velocity  at its begin.
/// @param span_s  how long it took, >= 0. Beyond a minute nothing is left to lose: longer spans
///   count as one.
CameraMotion unseenMotion(const Velocity& velocity, double span_s);

}  // namespace predictive_stereo
