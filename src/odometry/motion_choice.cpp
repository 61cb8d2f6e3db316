#include "odometry/motion_choice.h"

#include <algorithm>
#include <utility>

#include "odometry/rival_motions.h"
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

// Estimates the motion from several expectations, and keeps the best result.
class MotionTrials {
 public:
  MotionTrials(const StereoRig& rig, const ReferenceFrame& reference, double usual_share,
               double offset_jitter_px, const FollowFeatures& follow)
      : rig_(rig), reference_(reference), usual_share_(usual_share), follow_(follow) {
    params_.offset_jitter_px = offset_jitter_px;
    params_.common_errors = kCommonErrors;
  }

  // Does nothing if an earlier expectation was almost the same.
  void tryFrom(const Eigen::Isometry3d& T_expected) {
    for (const Eigen::Isometry3d& before : tried_)
      if (predictSamePositions(rig_, reference_, before, T_expected)) return;
    FollowedFeatures points = follow_(T_expected);
    PoseSolution solution = solve(points.correspondences, T_expected);
    // The covariance contains the effect of the offset, which is reported separately: remove it.
    const Vector6d by_offset = solution.by_disparity_errors.col(0);
    solution.covariance -= by_offset * by_offset.transpose();
    solution.found = solution.found && isCertain(solution.covariance);
    const bool is_first = tried_.empty();
    tried_.push_back(T_expected);
    if (!is_first && !isBetter(solution, points.correspondences)) return;
    best_ = std::move(solution);
    correspondences_ = std::move(points.correspondences);
    rows_ = std::move(points.rows);
    searched_ = std::max(points.searched, 1);
  }
  void tryFromBest() {
    if (best_.found) tryFrom(best_.T_cam_prev);
  }
  void tryFromOutliers() {
    if (!best_.found) return;
    std::vector<Correspondence> rest;
    for (size_t i = 0; i < correspondences_.size(); ++i)
      if (!best_.inlier[i]) rest.push_back(correspondences_[i]);
    const PoseSolution second = solve(rest, best_.T_cam_prev);
    if (second.found) tryFrom(second.T_cam_prev);
  }

  double inlierShare() const { return best_.inliers / searched_; }
  bool isAsUsual() const {
    return best_.found && best_.inliers > kUsualShare * usual_share_ * searched_;
  }
  bool hasFewInliers() const { return best_.inliers < kFirstUsualShare * searched_; }

  // Moves the result.
  MotionChoice result(bool doubtful) {
    MotionChoice choice;
    choice.doubtful = doubtful;
    choice.usual_share = usual_share_;
    if (best_.found) choice.usual_share = std::max(doubtful ? 0 : usual_share_, inlierShare());
    choice.solution = std::move(best_);
    choice.correspondences = std::move(correspondences_);
    choice.rows = std::move(rows_);
    return choice;
  }

 private:
  PoseSolution solve(const std::vector<Correspondence>& correspondences,
                     const Eigen::Isometry3d& T_expected) const {
    return solvePose(rig_, correspondences, T_expected, reference_.offset, kExpectedSigmaPx,
                     params_);
  }
  bool isBetter(const PoseSolution& other, const std::vector<Correspondence>& others) const {
    if (!other.found || !best_.found) return other.found;
    return isPreferred(other, support(other, others), best_, support(best_, correspondences_));
  }

  const StereoRig& rig_;
  const ReferenceFrame& reference_;
  const double usual_share_;
  const FollowFeatures& follow_;
  PoseSolverParams params_;
  std::vector<Eigen::Isometry3d> tried_;
  PoseSolution best_;
  std::vector<Correspondence> correspondences_;  // of the best
  std::optional<FeatureRows> rows_;              // likewise
  double searched_ = 1;                          // features, the same in all trials
};

}  // namespace

MotionChoice chooseMotion(const StereoRig& rig, const ReferenceFrame& reference,
                          const UsualMotion& usual, double offset_jitter_px,
                          const FollowFeatures& follow) {
  const Eigen::Isometry3d T_previous = reference.to_previous.T_cam_prev;
  const Eigen::Isometry3d T_expected = atConstantVelocity(reference, usual.T_cam_prev);
  MotionTrials trials(rig, reference, usual.inlier_share, offset_jitter_px, follow);
  trials.tryFrom(T_expected);
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
