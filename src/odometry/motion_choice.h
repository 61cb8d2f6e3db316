/// Chooses the motion of a frame among several candidates.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "odometry/pose_solver.h"
#include "odometry/reference_frame.h"
#include "odometry/stereo_features.h"

namespace predictive_stereo {

constexpr double kFirstUsualShare = 0.5;

/// What the last frames say about the next one.
struct UsualMotion {
  bool known = false;                                            ///< false before the first motion
  Eigen::Isometry3d T_cam_prev = Eigen::Isometry3d::Identity();  ///< the last frame's motion
  double interval_s = 0;  ///< between the two frames of this motion; infinite: not known
  /// Usual share of inliers among the tracked points, of motions that are not doubtful.
  double inlier_share = kFirstUsualShare;
};

struct MotionChoice {
  /// Since the reference. Its covariance does not contain the effect of the disparity offset.
  PoseSolution solution;
  std::vector<Correspondence> correspondences;  ///< what the solution is estimated from
  std::optional<FeatureRows> rows;  ///< FollowedFeatures::rows; without a solution of the first try
  int searched = 0;                 ///< FollowedFeatures::searched
  bool doubtful = false;            ///< whether the first expectation gave fewer inliers than usual
  double usual_share = 0;           ///< UsualMotion::inlier_share, for the next frame
};

/// Finds the features of the reference in the current frame, from their expected motion.
using FollowFeatures = std::function<FollowedFeatures(const Eigen::Isometry3d& T_expected)>;

/// Estimates the motion from a reference to the current frame.
///
/// The first expectation is constant velocity. If the share of inliers is lower than usual, the
/// result is doubtful, and other expectations are tried:
/// - the rotation of another sensor (R_since). It is also tried if less than kFirstUsualShare of
///   the points are inliers: after a fast turn few points are tracked, and these agree with many
///   motions.
/// - the result itself,
/// - no motion,
/// - the motion that the outliers agree with: among vehicles that move with the camera, most static
///   points are tracked only if they are expected at the right position.
/// The best motion is used, so that a wrong one does not become the next expectation. One that
/// accelerates more than cameras do counts less, see unlikeliness().
///
/// The first motion of all has rivals even if it is not doubtful, because no history says what is
/// static: the second motion that its points agree with, and the two of the points that are found
/// where a camera that moves ahead would see them. Points on the ground decide most: it is static,
/// and what stands on it may not be.
/// @param offset_jitter_px  as PoseSolverParams::offset_jitter_px.
MotionChoice chooseMotion(const StereoRig& rig, const ReferenceFrame& reference,
                          const UsualMotion& usual, double offset_jitter_px,
                          const FollowFeatures& follow);

/// How much speaks for a motion that was found: the trust of its inliers, divided by the geometric
/// mean of its six standard deviations. Static points are many and surround the camera; those of a
/// moving object are few, or close together. 0 if the determinant of the covariance is not
/// positive: its sigmas say nothing then.
double motionWorth(const PoseSolution& solution,
                   const std::vector<Correspondence>& correspondences);

/// Whether two motions predict most features at the same positions.
bool predictSamePositions(const StereoRig& rig, const ReferenceFrame& reference,
                          const Eigen::Isometry3d& T_a, const Eigen::Isometry3d& T_b);

/// The 0.9 quantile of the values, which are reordered; there must be at least one.
double highQuantile(std::vector<double>& values);

}  // namespace predictive_stereo
