#include "predictive_stereo/ego_motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "imaging/size_check.h"
#include "odometry/ego_motion_state.h"
#include "odometry/pose_solver.h"
#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {
namespace {

// The reference is kept while the image hardly moves: a camera that stands still does not drift.
constexpr double kHoldFlowPx = 1.5;
constexpr double kHoldInliers = 0.6;  // share of the searched features that must be in view
// A frame with fewer features cannot be a reference. The last reference is then kept, for at most
// EgoMotionEstimate::kMostFrames frames.
constexpr int kBlindFeatures = 30;

// Effect of calibration errors on a motion T = (R, t), in addition to those of disparities. A wrong
// scale makes t longer or shorter. An optical axis that is turned by w turns both frames:
// exp(w) T exp(-w).
void addCommonErrors(const EgoMotionParams& params, const StereoRig& rig,
                     EgoMotionEstimate& estimate) {
  const Eigen::Isometry3d& T = estimate.motion.T_cam_prev;
  CommonErrors& common = estimate.common_errors;
  common.middleCols<2>(1) *= params.disparity_tilt_sigma_px;
  common.col(3).head<3>() = params.scale_sigma * T.translation();
  common.rightCols<2>() = params.principal_point_sigma_px / rig.fx_px *
                          (Matrix6d::Identity() - adjoint(T)).middleCols<2>(3);
  estimate.motion.covariance += common * common.transpose();
}

// Such a pair has been refused by the caller.
bool hidesAll(const cv::Mat1b& ignored_mask) {
  return !ignored_mask.empty() &&
         cv::countNonZero(ignored_mask) == static_cast<int>(ignored_mask.total());
}

// Whether the camera is almost where the reference was seen, and sees most of it.
bool hardlyMoved(const MotionChoice& choice) {
  const PoseSolution& solution = choice.solution;
  if (solution.inliers < kHoldInliers * choice.searched) return false;
  std::vector<double> flow_px;
  for (size_t i = 0; i < choice.correspondences.size(); ++i) {
    const Correspondence& c = choice.correspondences[i];
    if (solution.inlier[i]) flow_px.push_back((c.current - c.previous).head<2>().norm());
  }
  return highQuantile(flow_px) < kHoldFlowPx;
}

// The motion of one frame, at constant velocity.
Eigen::Isometry3d motionPerFrame(const Eigen::Isometry3d& T_cam_prev, int frames) {
  return frames == 1 ? T_cam_prev : motionOf(constantTwist(T_cam_prev, frames), 1);
}

// Keeps the reference for the next frame, whose motion then starts at this frame.
void hold(ReferenceFrame& reference, const PoseSolution& solution) {
  reference.to_previous = {solution.T_cam_prev, solution.covariance};
  reference.by_disparity_errors = solution.by_disparity_errors;
  reference.age = 0;
  reference.since_s = 0;
  reference.R_since = Eigen::Matrix3d::Identity();
}

}  // namespace

EgoMotionEstimate EgoMotionState::estimate(const cv::Mat1b& left, const cv::Mat1b& right,
                                           const StereoRig& rig, const cv::Mat1b& ignored_mask,
                                           const std::optional<Eigen::Matrix3d>& R_cam_prev,
                                           double interval_s) {
  requireSize("left image", left.size(), rig.size);
  requireSize("right image", right.size(), rig.size);
  if (!ignored_mask.empty()) requireSize("mask of ignored pixels", ignored_mask.size(), rig.size);
  if (rig != features.rig()) {
    reset();
    startOffset();
  }
  features.setPair(left, right, rig);
  for (ReferenceFrame& reference : references) reference.addFrame(R_cam_prev, interval_s);

  MotionChoice choice;
  size_t used = 0;
  for (; used < references.size(); ++used) {
    choice = motionSince(references[used], ignored_mask);
    if (choice.solution.found) break;
  }

  EgoMotionEstimate estimate;
  estimate.swapped = (choice.doubtful || !choice.solution.found) && features.lookSwapped();
  if (estimate.swapped)
    choice.solution = PoseSolution();
  else if (choice.rows)
    features.keepRows(*choice.rows);
  estimate.features = static_cast<int>(choice.correspondences.size());
  estimate.inliers = choice.solution.inliers;
  estimate.residual_px = choice.solution.residual_px;
  if (choice.solution.found) {
    estimate.state = PoseState::kKnown;
    describeMotion(choice.solution, references[used], estimate);
    usual = {true, motionPerFrame(estimate.motion.T_cam_prev, estimate.frames),
             references[used].since_s / estimate.frames, choice.usual_share};
    offset = choice.solution.offset;
    steady_offset.update(offset);
    chooseReference(choice, used);
  } else {
    estimate.motion.covariance = Matrix6d::Identity() * kUnseenVariance;
    estimate.state = chooseReferencesAfterLoss(estimate.swapped || hidesAll(ignored_mask));
  }
  estimate.row_alignment = features.rowAlignment();
  if (params.estimate_disparity_offset) describeOffset(estimate);
  return estimate;
}

MotionChoice EgoMotionState::motionSince(const ReferenceFrame& reference,
                                         const cv::Mat1b& ignored_mask) {
  return chooseMotion(features.rig(), reference, usual, params.disparity_jitter_px,
                      [&](const Eigen::Isometry3d& T_expected) {
                        return features.follow(reference, T_expected, ignored_mask);
                      });
}

// The estimate's motion starts at the last frame that was tracked against the reference.
void EgoMotionState::describeMotion(const PoseSolution& solution, const ReferenceFrame& reference,
                                    EgoMotionEstimate& estimate) const {
  estimate.motion.T_cam_prev =
      compose(solution.T_cam_prev, reference.to_previous.T_cam_prev.inverse());
  // Both motions were estimated against the reference, with the same disparity offset.
  const Matrix6d A = adjoint(estimate.motion.T_cam_prev);
  estimate.common_errors.leftCols<3>() =
      solution.by_disparity_errors - A * reference.by_disparity_errors;
  estimate.motion.covariance =
      solution.covariance + A * reference.to_previous.covariance * A.transpose();
  addCommonErrors(params, features.rig(), estimate);
  estimate.frames = reference.age;
}

void EgoMotionState::describeOffset(EgoMotionEstimate& estimate) const {
  estimate.disparity_offset_px = offset.offset_px;
  const bool tracked = estimate.state == PoseState::kKnown;
  estimate.disparity_offset_sigma_px =
      std::sqrt((tracked ? offset : offsetNotTracked()).variance_px2);
  estimate.column_offset = steady_offset.column();
}

// The reference for the next frame: the same while the image hardly moves, otherwise this frame.
void EgoMotionState::chooseReference(const MotionChoice& choice, size_t used) {
  if (used == 0 && hardlyMoved(choice)) {
    hold(references.front(), choice.solution);
    references.resize(1);
  } else {
    ReferenceFrame here = makeReference(choice);
    references.clear();
    references.push_back(std::move(here));
  }
}

// References for the next frame: the last good one, then this one.
PoseState EgoMotionState::chooseReferencesAfterLoss(bool unusable) {
  drift(offset);
  if (!references.empty()) drift(references.front().offset);
  ReferenceFrame here = makeReference(MotionChoice());
  if (!references.empty() && references.front().age >= EgoMotionEstimate::kMostFrames)
    references.clear();
  const PoseState state = references.empty() ? PoseState::kLost : PoseState::kHeld;
  if (static_cast<int>(here.features.size()) < kBlindFeatures || unusable) return state;
  references.resize(std::min<size_t>(references.size(), 1));
  references.push_back(std::move(here));
  return state;
}

// Makes the current frame a reference, with what its motion says about its features.
ReferenceFrame EgoMotionState::makeReference(const MotionChoice& choice) {
  ReferenceFrame here = features.makeReference(choice.correspondences, choice.solution.inlier);
  if (!params.estimate_disparity_offset) return here;
  here.offset = choice.solution.found ? offset : offsetNotTracked();
  drift(here.offset);
  return here;
}

// Adds the drift of a frame. What was known before the first frame stays known.
void EgoMotionState::drift(DisparityOffset& some_offset) const {
  if (!params.estimate_disparity_offset) return;
  const double start_px2 = params.disparity_offset_sigma_px * params.disparity_offset_sigma_px;
  const double drift_px2 = params.disparity_offset_drift_px * params.disparity_offset_drift_px;
  double& variance_px2 = some_offset.variance_px2;
  variance_px2 = std::min(variance_px2 + drift_px2, std::max(variance_px2, start_px2));
}

// The cameras may have shaken since the last frame that was tracked.
DisparityOffset EgoMotionState::offsetNotTracked() const {
  DisparityOffset result = offset;
  if (params.estimate_disparity_offset)
    result.variance_px2 += params.disparity_jitter_px * params.disparity_jitter_px;
  return result;
}

EgoMotion::EgoMotion(const EgoMotionParams& params)
    : state_(std::make_unique<EgoMotionState>(params)) {}
EgoMotion::~EgoMotion() = default;
EgoMotion::EgoMotion(EgoMotion&&) noexcept = default;
EgoMotion& EgoMotion::operator=(EgoMotion&&) noexcept = default;

EgoMotionEstimate EgoMotion::estimate(const cv::Mat1b& left, const cv::Mat1b& right,
                                      const StereoRig& rig, const cv::Mat1b& ignored_mask,
                                      const std::optional<Eigen::Matrix3d>& R_cam_prev,
                                      double interval_s) {
  return state_->estimate(left, right, rig, ignored_mask, R_cam_prev, interval_s);
}

void EgoMotion::setParams(const EgoMotionParams& params) { state_->setParams(params); }

void EgoMotion::reset() { state_->reset(); }

}  // namespace predictive_stereo
