#include "odometry/motion_choice.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "predictive_stereo/disparity_motion.h"
#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {
namespace {

constexpr double kExpectedSigmaPx = 0.3;  // of a coordinate, before it has been estimated
// Errors of neighbouring points are correlated (patches at occlusion boundaries, interpolation),
// which the normal equations ignore. With this factor the mean of e'C^-1e / 6 of single motions is
// 0.9 on eleven synthetic scenes.
constexpr double kCommonErrors = 2.6;
// A motion with a larger standard deviation counts as lost.
constexpr double kLargestSigma_m = 0.5, kLargestSigma_rad = 0.05;
// A motion is doubtful, and others are tried, if its share of inliers among the tracked points is
// below this part of the usual share.
constexpr double kUsualShare = 2.0 / 3;
// Of the median depth, see movedAhead.
constexpr double kAheadByDepth = 0.1;
// The largest one of a camera that is carried, driven or flown.
constexpr double kLargestAcceleration_mps2 = 30;
// At the start, each point on the ground counts as this many others.
constexpr double kGroundTrust = 10;
constexpr double kGroundHeight = 0.2;   // of its points at most, relative to the camera's height
constexpr double kNearDisparityPx = 2;  // the height of a farther point is not known
constexpr double kSamePlacePx = 2;      // tracking finds features from much farther away
constexpr double kFarPx = 1e6;          // also replaces NaN, of points beside the camera

bool isCertain(const Matrix6d& covariance) {
  const double largest_m2 = covariance.diagonal().head<3>().maxCoeff();
  const double largest_rad2 = covariance.diagonal().tail<3>().maxCoeff();
  return largest_m2 < kLargestSigma_m * kLargestSigma_m &&
         largest_rad2 < kLargestSigma_rad * kLargestSigma_rad;
}

// T_cam_prev with the rotation R_cam_prev about the same position of the camera.
Eigen::Isometry3d withRotation(const Eigen::Matrix3d& R_cam_prev,
                               const Eigen::Isometry3d& T_cam_prev) {
  const Eigen::Quaterniond q(R_cam_prev * T_cam_prev.linear().transpose());
  return compose(Eigen::Isometry3d(q.normalized()), T_cam_prev);
}

// The motion of each frame since the reference is that of the last frame.
Eigen::Isometry3d atConstantVelocity(const ReferenceFrame& reference,
                                     const Eigen::Isometry3d& T_last) {
  Eigen::Isometry3d T = reference.to_previous.T_cam_prev;
  for (int i = 0; i < std::min(reference.age, 3); ++i) T = compose(T_last, T);
  return T;
}

// A camera that moves ahead, by a part of the median depth: between its capture range around zero
// and around this motion, tracking finds the static points of most drives.
Eigen::Isometry3d movedAhead(const StereoRig& rig, const ReferenceFrame& reference) {
  std::vector<float> disparities_px;
  for (const Feature& feature : reference.features)
    if (feature.disparity_px > 0) disparities_px.push_back(feature.disparity_px);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  if (disparities_px.empty()) return T;
  const auto middle =
      disparities_px.begin() + static_cast<std::ptrdiff_t>(disparities_px.size() / 2);
  std::nth_element(disparities_px.begin(), middle, disparities_px.end());
  T.translation().z() = -kAheadByDepth * rig.fx_px * rig.baseline_m / *middle;
  return T;
}

// What is static is not known at the start, but the ground is: raises the trust of the points near
// the lowest ones.
void trustGround(const StereoRig& rig, std::vector<Correspondence>& points) {
  const auto below_camera = [&](const Correspondence& c) {
    return c.previous.z() > kNearDisparityPx ? (c.previous.y() - rig.cy_px) / c.previous.z() : 0;
  };
  std::vector<double> all;
  for (const Correspondence& c : points)
    if (below_camera(c) > 0) all.push_back(below_camera(c));
  if (all.empty()) return;
  const double lowest = highQuantile(all);
  for (Correspondence& c : points)
    if (below_camera(c) > (1 - kGroundHeight) * lowest) c.trust *= kGroundTrust;
}

// The features of the reference, followed from one expectation, and what most of them agree with.
struct Trial {
  FollowedFeatures points;
  PoseSolution solution;
};

// Estimates the motion from several expectations, and keeps the best result.
class MotionTrials {
 public:
  MotionTrials(const StereoRig& rig, const ReferenceFrame& reference, const UsualMotion& usual,
               double offset_jitter_px, const FollowFeatures& follow)
      : rig_(rig), reference_(reference), usual_(usual), follow_(follow) {
    params_.offset_jitter_px = offset_jitter_px;
    params_.common_errors = kCommonErrors;
    const double frames = reference.since_s / usual.interval_s;
    if (!usual.known || !std::isfinite(usual.interval_s) || !std::isfinite(frames)) return;
    params_.likely_position_m = compose(motionOf(constantTwist(usual.T_cam_prev, 1), frames),
                                        reference.to_previous.T_cam_prev)
                                    .inverse()
                                    .translation();
    params_.likely_radius_m = kLargestAcceleration_mps2 * reference.since_s * reference.since_s;
  }

  // Does nothing if an earlier expectation was almost the same.
  void tryFrom(const Eigen::Isometry3d& T_expected) {
    if (wasTried(T_expected)) return;
    const bool is_first = tried_.empty();
    Trial trial = follow(T_expected);
    if (is_first || isBetter(trial)) best_ = std::move(trial);
  }
  // The same for a motion that replaces only a different one.
  void tryRivalFrom(const Eigen::Isometry3d& T_expected) {
    if (wasTried(T_expected)) return;
    Trial trial = follow(T_expected);
    if (!isSameAsBest(trial.solution) && isBetter(trial)) best_ = std::move(trial);
  }
  void tryFromBest() {
    if (best_.solution.found) tryFrom(best_.solution.T_cam_prev);
  }
  void tryFromOutliers() {
    if (!best_.solution.found) return;
    const PoseSolution second =
        solve(outliers(best_.points, best_.solution), best_.solution.T_cam_prev);
    if (second.found) tryFrom(second.T_cam_prev);
  }

  double inlierShare() const { return best_.solution.inliers / searched(); }
  bool isAsUsual() const {
    return best_.solution.found && inlierShare() > kUsualShare * usual_.inlier_share;
  }
  bool hasFewInliers() const { return inlierShare() < kFirstUsualShare; }

  // Moves the result.
  MotionChoice result(bool doubtful) {
    MotionChoice choice;
    choice.doubtful = doubtful;
    choice.usual_share = usual_.inlier_share;
    if (best_.solution.found)
      choice.usual_share = std::max(doubtful ? 0 : usual_.inlier_share, inlierShare());
    choice.solution = std::move(best_.solution);
    choice.correspondences = std::move(best_.points.correspondences);
    choice.rows = std::move(best_.points.rows);
    choice.searched = best_.points.searched;
    return choice;
  }

 private:
  bool wasTried(const Eigen::Isometry3d& T_expected) const {
    return std::any_of(tried_.begin(), tried_.end(), [&](const Eigen::Isometry3d& before) {
      return predictSamePositions(rig_, reference_, before, T_expected);
    });
  }
  Trial follow(const Eigen::Isometry3d& T_expected) {
    tried_.push_back(T_expected);
    Trial trial{follow_(T_expected), {}};
    if (!usual_.known) trustGround(rig_, trial.points.correspondences);
    trial.solution = solve(trial.points.correspondences, T_expected);
    if (!usual_.known) weighSecondMotion(T_expected, trial);
    return trial;
  }
  PoseSolution solve(const std::vector<Correspondence>& correspondences,
                     const Eigen::Isometry3d& T_expected) const {
    PoseSolution solution =
        solvePose(rig_, correspondences, T_expected, reference_.offset, kExpectedSigmaPx, params_);
    // The covariance contains the effect of the offset, which is reported separately: remove it.
    const Vector6d by_offset = solution.by_disparity_errors.col(0);
    solution.covariance -= by_offset * by_offset.transpose();
    solution.found = solution.found && isCertain(solution.covariance);
    return solution;
  }
  static std::vector<Correspondence> outliers(const FollowedFeatures& points,
                                              const PoseSolution& solution) {
    std::vector<Correspondence> rest;
    for (size_t i = 0; i < points.correspondences.size(); ++i)
      if (!solution.inlier[i]) rest.push_back(points.correspondences[i]);
    return rest;
  }
  // Takes the motion that the outliers of a trial agree with, if it is preferred.
  void weighSecondMotion(const Eigen::Isometry3d& T_expected, Trial& trial) const {
    PoseSolution& first = trial.solution;
    if (!first.found) return;
    PoseSolution second = solve(outliers(trial.points, first), T_expected);
    if (!second.found) return;
    std::vector<char> inlier(trial.points.correspondences.size(), 0);
    for (size_t i = 0, k = 0; i < inlier.size(); ++i)
      if (!first.inlier[i]) inlier[i] = second.inlier[k++];
    second.inlier = std::move(inlier);
    const std::vector<Correspondence>& points = trial.points.correspondences;
    if (motionWorth(second, points) > motionWorth(first, points)) first = std::move(second);
  }
  bool isSameAsBest(const PoseSolution& solution) const {
    return solution.found && best_.solution.found &&
           predictSamePositions(rig_, reference_, solution.T_cam_prev, best_.solution.T_cam_prev);
  }
  bool isBetter(const Trial& other) const {
    if (!other.solution.found || !best_.solution.found) return other.solution.found;
    return worth(other) > worth(best_);
  }
  double worth(const Trial& trial) const {
    return motionWorth(trial.solution, trial.points.correspondences) /
           unlikeliness(trial.solution, params_);
  }
  double searched() const { return std::max(best_.points.searched, 1); }

  const StereoRig& rig_;
  const ReferenceFrame& reference_;
  const UsualMotion& usual_;
  const FollowFeatures& follow_;
  PoseSolverParams params_;
  std::vector<Eigen::Isometry3d> tried_;
  Trial best_;
};

}  // namespace

double motionWorth(const PoseSolution& solution,
                   const std::vector<Correspondence>& correspondences) {
  double support = 0;
  for (size_t i = 0; i < correspondences.size(); ++i)
    if (solution.inlier[i]) support += correspondences[i].trust;
  const double determinant = solution.covariance.determinant();
  return determinant > 0 ? support / std::pow(determinant, 1.0 / 12) : 0;
}

bool predictSamePositions(const StereoRig& rig, const ReferenceFrame& reference,
                          const Eigen::Isometry3d& T_a, const Eigen::Isometry3d& T_b) {
  const Eigen::Matrix4d by_a = disparityMotion(rig, T_a), by_b = disparityMotion(rig, T_b);
  std::vector<double> apart_px;
  for (const Feature& feature : reference.features) {
    const Eigen::Vector4d point(feature.position.x, feature.position.y,
                                feature.disparity_px + reference.offset.offset_px, 1);
    const double px =
        ((by_a * point).hnormalized() - (by_b * point).hnormalized()).head<2>().norm();
    apart_px.push_back(std::min(kFarPx, px));
  }
  return highQuantile(apart_px) < kSamePlacePx;
}

double highQuantile(std::vector<double>& values) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 9 / 10);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

MotionChoice chooseMotion(const StereoRig& rig, const ReferenceFrame& reference,
                          const UsualMotion& usual, double offset_jitter_px,
                          const FollowFeatures& follow) {
  const Eigen::Isometry3d T_previous = reference.to_previous.T_cam_prev;
  const Eigen::Isometry3d T_expected = atConstantVelocity(reference, usual.T_cam_prev);
  MotionTrials trials(rig, reference, usual, offset_jitter_px, follow);
  trials.tryFrom(T_expected);
  if (!usual.known) trials.tryRivalFrom(compose(movedAhead(rig, reference), T_previous));
  const bool doubtful = !trials.isAsUsual();
  const bool ask_sensor = reference.R_since && (doubtful || trials.hasFewInliers());
  if (!doubtful && !ask_sensor) return trials.result(doubtful);

  if (ask_sensor) {
    // With the expected translation, or with none.
    const Eigen::Matrix3d R_prior = *reference.R_since * T_previous.linear();
    trials.tryFrom(withRotation(R_prior, T_expected));
    if (!trials.isAsUsual()) trials.tryFrom(withRotation(R_prior, T_previous));
  }
  trials.tryFromBest();
  if (!trials.isAsUsual()) {
    trials.tryFrom(T_previous);
    trials.tryFromBest();
  }
  if (!trials.isAsUsual()) trials.tryFromOutliers();
  return trials.result(doubtful);
}

}  // namespace predictive_stereo
