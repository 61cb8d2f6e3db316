#include "predictive_stereo/ego_motion.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "odometry/ego_motion_fault.h"
#include "odometry/features.h"
#include "odometry/pose_solver.h"
#include "odometry/reference_frame.h"
#include "odometry/rival_motions.h"
#include "odometry/steady_offset.h"
#include "odometry/stereo_depth.h"
#include "odometry/tracking.h"
#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {
namespace {

constexpr int kLevels = 4;
constexpr int kBorderPx = 10;             // room for a patch with its gradients
constexpr double kExpectedSigmaPx = 0.3;  // of a coordinate, before it has been estimated
// The relative variance of a coordinate is 1 (interpolation, depth within the patch: 0.07 px) plus
// this factor times its variance [px^2] for image noise of one grey level. Estimated on the scenes
// drone, robot and handheld.
constexpr double kNoiseVariance = 3000;
constexpr double kLostCovariance = 9999;
// Likelihood that a point is static: of a new point, of an inlier of the last motion, of an
// outlier.
constexpr double kNewTrust = 0.5, kStaticTrust = 1.0, kMovingTrust = 0.2;
// The reference is kept while the image hardly moves: a camera that stands still does not drift.
constexpr double kHoldFlowPx = 1.5;
constexpr double kHoldInliers = 0.6;  // share of the reference's features that must be in view
// A motion is doubtful, and others are tried, if its share of inliers among the tracked points is
// below this part of the usual share.
constexpr double kUsualShare = 2.0 / 3, kFirstUsualShare = 0.5;
// A frame with fewer features cannot be a reference. The last reference is then kept, for at most
// kLongestWait frames.
constexpr int kBlindFeatures = 30;
constexpr int kLongestWait = 10;
// Errors of neighbouring points are correlated (patches at occlusion boundaries, interpolation),
// which the normal equations ignore. With this factor the mean of e'C^-1e / 6 of single motions is
// 0.9 on eleven synthetic scenes.
constexpr double kCommonErrors = 2.6;
constexpr int kSwappedShiftPx = 3;  // disparities below minus this mean swapped images
// A motion with a larger standard deviation counts as lost.
constexpr double kLargestSigma_m = 0.5, kLargestSigma_rad = 0.05;

void requireSize(const char* name, const cv::Mat1b& image, cv::Size size) {
  const auto text = [](cv::Size s) {
    return std::to_string(s.width) + "x" + std::to_string(s.height);
  };
  if (image.size() != size)
    throw std::invalid_argument(std::string("ego-motion: the ") + name + " is " +
                                text(image.size()) + ", the rig's images are " + text(size) +
                                "; do the camera_info topics belong to these images?");
}

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

// Relative variances of tracks and disparities, see Correspondence.
Eigen::Vector2d relativeVariance(const Track& track) {
  return {1 + kNoiseVariance * track.variance_px2[0], 1 + kNoiseVariance * track.variance_px2[1]};
}
double relativeVariance(const StereoMatch& match) {
  return 1 + kNoiseVariance * match.shift_variance_px2;
}

// T_cam_prev with the rotation R_cam_prev about the same position of the camera.
Eigen::Isometry3d withRotation(const Eigen::Matrix3d& R_cam_prev,
                               const Eigen::Isometry3d& T_cam_prev) {
  const Eigen::Quaterniond q(R_cam_prev * T_cam_prev.linear().transpose());
  return compose(Eigen::Isometry3d(q.normalized()), T_cam_prev);
}

bool isCertain(const Matrix6d& covariance) {
  const double largest_m2 = covariance.diagonal().head<3>().maxCoeff();
  const double largest_rad2 = covariance.diagonal().tail<3>().maxCoeff();
  return largest_m2 < kLargestSigma_m * kLargestSigma_m &&
         largest_rad2 < kLargestSigma_rad * kLargestSigma_rad;
}

}  // namespace

struct EgoMotion::State {
  explicit State(const EgoMotionParams& p) : params(p), row_offsets(p.row_alignment) {
    validate(p, "ego_motion/");
    startOffset();
  }

  void setParams(const EgoMotionParams& p) {
    validate(p, "ego_motion/");
    const bool other_offset = p.estimate_disparity_offset != params.estimate_disparity_offset;
    params = p;
    row_offsets.setParams(p.row_alignment);
    if (!p.row_alignment.enabled) alignment = RowOffsetModel();
    if (!other_offset) return;
    reset();
    startOffset();
  }
  void startOffset() {
    offset = DisparityOffset();
    steady_offset = SteadyOffset();
    if (params.estimate_disparity_offset)
      offset.variance_px2 = params.disparity_offset_sigma_px * params.disparity_offset_sigma_px;
  }

  EgoMotionEstimate estimate(const cv::Mat1b& left, const cv::Mat1b& right,
                             const StereoRig& new_rig, const cv::Mat1b& moving_mask,
                             const std::optional<Eigen::Matrix3d>& R_cam_prev);
  void reset();

  PoseSolution motionSince(const ReferenceFrame& reference, const cv::Mat1b& moving_mask);
  PoseSolution tryMotion(const ReferenceFrame& reference, const Eigen::Isometry3d& T_expected,
                         const cv::Mat1b& moving_mask);
  PoseSolverParams solverParams() const {
    PoseSolverParams solver;
    solver.offset_jitter_px = params.disparity_jitter_px;
    solver.common_errors = kCommonErrors;
    return solver;
  }
  void followFeatures(const ReferenceFrame& reference, const Eigen::Isometry3d& T_expected,
                      const cv::Mat1b& moving_mask);
  StereoSearch stereoSearch() const;
  void findInRightImage(std::vector<StereoMatch>& stereo);
  bool looksSwapped();
  float disparity(const StereoMatch& match) const;
  void updateRowAlignment(const std::vector<StereoMatch>& stereo);
  bool hardlyMoved(const PoseSolution& solution) const;
  ReferenceFrame makeReferenceFrame(const PoseSolution& solution);

  EgoMotionParams params;
  StereoRig rig;
  ImagePyramid left_pyramid, right_pyramid;  // of the current frame
  RowOffsetFilter row_offsets;
  RowOffsetModel alignment;
  DisparityOffset offset;  // of the last frame that was tracked
  SteadyOffset steady_offset;
  Eigen::Isometry3d T_last = Eigen::Isometry3d::Identity();  // the last frame's motion
  // Reference frames for the next frame, best first: one, or two after a loss.
  std::vector<ReferenceFrame> references;

  // Usual share of inliers among the tracked points, of motions that are not doubtful.
  double usual_share = kFirstUsualShare;
  bool doubted = false;  // whether the current frame's motion is doubtful

  CornerDetector detector;
  // Features of a reference that are tracked into the current frame; `id` is the feature's index.
  std::vector<Track> tracks;
  std::vector<StereoMatch> matches;
  std::vector<Correspondence> correspondences;  // one per match
};

void EgoMotion::State::reset() {
  references.clear();
  row_offsets.reset();
  alignment = RowOffsetModel();
  T_last = Eigen::Isometry3d::Identity();
  usual_share = kFirstUsualShare;
}

EgoMotionEstimate EgoMotion::State::estimate(const cv::Mat1b& left, const cv::Mat1b& right,
                                             const StereoRig& new_rig, const cv::Mat1b& moving_mask,
                                             const std::optional<Eigen::Matrix3d>& R_cam_prev) {
  requireSize("left image", left, new_rig.size);
  requireSize("right image", right, new_rig.size);
  if (!moving_mask.empty()) requireSize("mask of moving objects", moving_mask, new_rig.size);
  if (new_rig != rig) {
    reset();
    startOffset();
  }
  rig = new_rig;
  left_pyramid.build(left, kLevels);
  right_pyramid.buildOn(right, 2);

  EgoMotionEstimate estimate;
  PoseSolution solution;
  correspondences.clear();
  const double share_before = usual_share;
  size_t used = 0;
  for (ReferenceFrame& reference : references) reference.addFrame(R_cam_prev);
  for (; used < references.size(); ++used) {
    solution = motionSince(references[used], moving_mask);
    if (solution.found) break;
  }
  estimate.swapped = !references.empty() && (doubted || !solution.found) && looksSwapped();
  if (estimate.swapped) {
    solution = PoseSolution();
    usual_share = share_before;
  }
  estimate.features = static_cast<int>(correspondences.size());
  estimate.inliers = solution.inliers;
  estimate.residual_px = solution.residual_px;

  if (solution.found) {
    estimate.status = EgoMotionStatus::kTracked;
    ReferenceFrame& reference = references[used];
    estimate.motion.T_cam_prev =
        compose(solution.T_cam_prev, reference.to_previous.T_cam_prev.inverse());
    // Both motions were estimated against the reference, with the same disparity offset.
    const Matrix6d A = adjoint(estimate.motion.T_cam_prev);
    estimate.common_errors.leftCols<3>() =
        solution.by_disparity_errors - A * reference.by_disparity_errors;
    estimate.motion.covariance =
        solution.covariance + A * reference.to_previous.covariance * A.transpose();
    addCommonErrors(params, rig, estimate);
    estimate.frames = reference.age;
    T_last = estimate.motion.T_cam_prev;
    offset = solution.offset;
    steady_offset.update(offset);
    if (used == 0 && hardlyMoved(solution)) {
      reference.to_previous = {solution.T_cam_prev, solution.covariance};
      reference.by_disparity_errors = solution.by_disparity_errors;
      reference.age = 0;
      reference.R_since = Eigen::Matrix3d::Identity();
      references.resize(1);
    } else {
      ReferenceFrame here = makeReferenceFrame(solution);
      references.clear();
      references.push_back(std::move(here));
    }
  } else {
    estimate.status = references.empty() ? EgoMotionStatus::kFirstFrame : EgoMotionStatus::kLost;
    if (!references.empty()) estimate.motion.covariance = Matrix6d::Identity() * kLostCovariance;
    // The pose is held. References for the next frame: the last good one, then this one.
    correspondences.clear();
    ReferenceFrame here = makeReferenceFrame(solution);
    if (!references.empty() && references.front().age >= kLongestWait) references.clear();
    if (static_cast<int>(here.features.size()) >= kBlindFeatures && !estimate.swapped) {
      references.resize(std::min<size_t>(references.size(), 1));
      references.push_back(std::move(here));
    }
  }
  estimate.row_alignment = alignment;
  if (params.estimate_disparity_offset) {
    estimate.disparity_offset_px = offset.offset_px;
    estimate.disparity_offset_sigma_px = std::sqrt(offset.variance_px2);
    estimate.column_offset.known = steady_offset.isCertain();
    estimate.column_offset.offset_px = steady_offset.mean_px();
    estimate.column_offset.sigma_px = steady_offset.sigma_px();
    estimate.column_offset.correction_px = steady_offset.correction_px();
  }
  return estimate;
}

// Estimates the motion from a reference to the current frame. The first expectation is constant
// velocity. If the share of inliers is lower than usual, the result is doubtful, and other
// expectations are tried:
// - the rotation of another sensor (R_since). It is also tried if less than kFirstUsualShare of the
//   points are inliers: after a fast turn few points are tracked, and these agree with many
//   motions.
// - the result itself,
// - no motion,
// - the motion that the outliers agree with: among vehicles that move with the camera, most static
//   points are tracked only if they are expected at the right position.
// The best motion is used, so that a wrong one does not become the next expectation.
PoseSolution EgoMotion::State::motionSince(const ReferenceFrame& reference,
                                           const cv::Mat1b& moving_mask) {
  const Eigen::Isometry3d T_previous = reference.to_previous.T_cam_prev;
  Eigen::Isometry3d T_expected = T_previous;
  for (int i = 0; i < std::min(reference.age, 3); ++i) T_expected = compose(T_last, T_expected);
  PoseSolution best = tryMotion(reference, T_expected, moving_mask);
  const auto followed = static_cast<double>(std::max<size_t>(tracks.size(), 1));
  const auto isAsUsual = [&] {
    return best.found && best.inliers > kUsualShare * usual_share * followed;
  };
  doubted = !isAsUsual();
  const bool ask_others =
      reference.R_since && (doubted || best.inliers < kFirstUsualShare * followed);
  if (!doubted && !ask_others) {
    usual_share = std::max(usual_share, best.inliers / followed);
    return best;
  }

  std::vector<StereoMatch> best_matches = matches;
  std::vector<Correspondence> best_correspondences = correspondences;
  std::vector<Eigen::Isometry3d> tried = {T_expected};
  const auto tryMotionInstead = [&](const Eigen::Isometry3d& T) {
    for (const Eigen::Isometry3d& before : tried)
      if (predictSamePositions(rig, reference, before, T)) return;
    tried.push_back(T);
    const PoseSolution other = tryMotion(reference, T, moving_mask);
    if (!other.found || (best.found && !isPreferred(other, support(other, correspondences), best,
                                                    support(best, best_correspondences))))
      return;
    best = other;
    best_matches = matches;
    best_correspondences = correspondences;
  };
  if (ask_others) {
    // With the expected translation, or with none.
    const Eigen::Matrix3d R_prior = *reference.R_since * T_previous.linear();
    tryMotionInstead(withRotation(R_prior, T_expected));
    if (!isAsUsual()) tryMotionInstead(withRotation(R_prior, T_previous));
  }
  if (best.found) tryMotionInstead(best.T_cam_prev);
  if (!isAsUsual()) {
    tryMotionInstead(T_previous);
    if (best.found) tryMotionInstead(best.T_cam_prev);
  }
  if (best.found && !isAsUsual()) {
    std::vector<Correspondence> rest;
    for (size_t i = 0; i < best_correspondences.size(); ++i)
      if (!best.inlier[i]) rest.push_back(best_correspondences[i]);
    const PoseSolution second =
        solvePose(rig, rest, best.T_cam_prev, reference.offset, kExpectedSigmaPx, solverParams());
    if (second.found) tryMotionInstead(second.T_cam_prev);
  }
  std::swap(matches, best_matches);
  std::swap(correspondences, best_correspondences);
  if (best.found) usual_share = std::max(doubted ? 0 : usual_share, best.inliers / followed);
  return best;
}

PoseSolution EgoMotion::State::tryMotion(const ReferenceFrame& reference,
                                         const Eigen::Isometry3d& T_expected,
                                         const cv::Mat1b& moving_mask) {
  followFeatures(reference, T_expected, moving_mask);
  findInRightImage(matches);
  updateRowAlignment(matches);
  correspondences.clear();
  auto track = tracks.begin();  // tracks and matches are both in the order of features
  for (const StereoMatch& match : matches) {
    const Feature& feature = reference.features[match.id];
    Correspondence c;
    c.previous << feature.position.x, feature.position.y, feature.disparity_px;
    c.current << match.point.x, match.point.y, disparity(match);
    while (track->id != match.id) ++track;
    c.track_variance = relativeVariance(*track);
    c.previous_disparity_variance = feature.disparity_variance;
    c.current_disparity_variance = relativeVariance(match);
    c.trust = feature.trust;
    correspondences.push_back(c);
  }
  PoseSolution solution = solvePose(rig, correspondences, T_expected, reference.offset,
                                    kExpectedSigmaPx, solverParams());
  // The covariance contains the effect of the offset, which is reported separately: remove it.
  const Vector6d by_offset = solution.by_disparity_errors.col(0);
  solution.covariance -= by_offset * by_offset.transpose();
  solution.found = solution.found && isCertain(solution.covariance);
  return solution;
}

// Tracks the reference's features into the current left image, and sets their expected shift to the
// right one.
void EgoMotion::State::followFeatures(const ReferenceFrame& reference,
                                      const Eigen::Isometry3d& T_expected,
                                      const cv::Mat1b& moving_mask) {
  const Eigen::Matrix4d H = disparityMotion(rig, T_expected);
  const double offset_px = reference.offset.offset_px;
  const cv::Rect2d image(0, 0, rig.size.width, rig.size.height);
  tracks.clear();
  std::vector<float> expected_px(reference.features.size());
  for (size_t i = 0; i < reference.features.size(); ++i) {
    const Feature& feature = reference.features[i];
    if (!moving_mask.empty() && moving_mask(cv::Point(feature.position))) continue;
    Track track;
    track.id = static_cast<int>(i);
    track.origin = track.position = feature.position;
    expected_px[i] = feature.disparity_px;
    Eigen::Vector4d expected = H * Eigen::Vector4d(feature.position.x, feature.position.y,
                                                   feature.disparity_px + offset_px, 1);
    const double size_change = expected.w();  // current depth / reference depth
    expected /= expected.w();
    if (size_change > 0 && image.contains(cv::Point2d(expected.x(), expected.y())) &&
        expected.z() < params.max_disparity_px) {
      track.position = cv::Point2d(expected.x(), expected.y());
      track.scale = static_cast<float>(std::clamp(size_change, 0.6, 1.6));
      expected_px[i] = static_cast<float>(expected.z() - offset_px);
    }
    tracks.push_back(track);
  }
  trackPoints(reference.left, left_pyramid, tracks);
  matches.clear();
  for (const Track& track : tracks) {
    if (!track.found) continue;
    StereoMatch match;
    match.id = track.id;
    match.point = track.position;
    match.expected = true;
    match.shift_px = expected_px[track.id] + static_cast<float>(rig.cx_left_px - rig.cx_right_px);
    matches.push_back(match);
  }
}

StereoSearch EgoMotion::State::stereoSearch() const {
  StereoSearch search;
  search.largest_shift_px =
      params.max_disparity_px + static_cast<int>(std::ceil(rig.cx_left_px - rig.cx_right_px));
  search.smallest_shift_px += static_cast<int>(std::floor(rig.cx_left_px - rig.cx_right_px));
  return search;
}

// Removes the points that are not found.
void EgoMotion::State::findInRightImage(std::vector<StereoMatch>& stereo) {
  StereoSearch search = stereoSearch();
  if (!alignment.isIdentity()) search.row_radius_px = 0;
  matchStereo(left_pyramid, right_pyramid, alignment, search, stereo);
  stereo.erase(std::remove_if(stereo.begin(), stereo.end(),
                              [](const StereoMatch& match) { return !match.found; }),
               stereo.end());
}

// Whether far more corners match with negative disparities than with positive ones.
bool EgoMotion::State::looksSwapped() {
  std::vector<cv::Point2f> corners;
  detector.detect(left_pyramid.level(0), params.features, {}, kBorderPx, corners);
  const auto found = [&](const StereoSearch& search) {
    std::vector<StereoMatch> stereo(corners.size());
    for (size_t i = 0; i < corners.size(); ++i) stereo[i].point = corners[i];
    matchStereo(left_pyramid, right_pyramid, RowOffsetModel(), search, stereo);
    return std::count_if(stereo.begin(), stereo.end(),
                         [](const StereoMatch& match) { return match.found; });
  };
  const StereoSearch search = stereoSearch();
  StereoSearch swapped = search;
  swapped.largest_shift_px = -kSwappedShiftPx;
  swapped.smallest_shift_px = -search.largest_shift_px;
  const auto as_swapped = found(swapped);
  return as_swapped >= kBlindFeatures && as_swapped > 2 * found(search);
}

float EgoMotion::State::disparity(const StereoMatch& match) const {
  float shift_px = match.shift_px;
  if (!alignment.isIdentity()) {
    const auto row_offset = static_cast<float>(
        alignment.offset(match.point.x - match.shift_px, match.point.y, rig.size));
    shift_px += match.shift_by_row * (match.row_offset_px - row_offset);
  }
  return shift_px - static_cast<float>(rig.cx_left_px - rig.cx_right_px);
}

void EgoMotion::State::updateRowAlignment(const std::vector<StereoMatch>& stereo) {
  if (!params.row_alignment.enabled) return;
  std::vector<RowOffsetMeasurement> samples;
  for (const StereoMatch& match : stereo)
    samples.push_back({match.point.x - match.shift_px, match.point.y, match.row_offset_px});
  alignment = row_offsets.update(samples, rig.size);
}

bool EgoMotion::State::hardlyMoved(const PoseSolution& solution) const {
  const ReferenceFrame& reference = references.front();
  if (solution.inliers < kHoldInliers * static_cast<double>(reference.features.size()))
    return false;
  std::vector<double> flow_px;
  for (size_t i = 0; i < correspondences.size(); ++i)
    if (solution.inlier[i])
      flow_px.push_back(
          (correspondences[i].current - correspondences[i].previous).head<2>().norm());
  return highQuantile(flow_px) < kHoldFlowPx;
}

// Makes the current frame a reference: keeps its correspondences as features, and adds new corners
// between them. Moves the current pyramid.
ReferenceFrame EgoMotion::State::makeReferenceFrame(const PoseSolution& solution) {
  ReferenceFrame here;
  here.offset = offset;
  if (params.estimate_disparity_offset)
    here.offset.variance_px2 += params.disparity_offset_drift_px * params.disparity_offset_drift_px;
  else
    here.offset = DisparityOffset();
  std::vector<cv::Point2f> taken, corners;
  for (size_t i = 0; i < correspondences.size(); ++i) {
    const Correspondence& c = correspondences[i];
    const cv::Point2f position = cv::Point2d(c.current.x(), c.current.y());
    here.features.push_back({position, static_cast<float>(c.current.z()),
                             c.current_disparity_variance,
                             solution.inlier[i] ? kStaticTrust : kMovingTrust});
    taken.push_back(position);
  }
  detector.detect(left_pyramid.level(0), params.features, taken, kBorderPx, corners);
  std::vector<StereoMatch> stereo(corners.size());
  for (size_t i = 0; i < corners.size(); ++i) stereo[i].point = corners[i];
  findInRightImage(stereo);
  if (alignment.isIdentity()) updateRowAlignment(stereo);
  for (const StereoMatch& match : stereo)
    here.features.push_back({match.point, disparity(match), relativeVariance(match), kNewTrust});
  std::swap(here.left, left_pyramid);
  return here;
}

EgoMotion::EgoMotion(const EgoMotionParams& params) : state_(std::make_unique<State>(params)) {}
EgoMotion::~EgoMotion() = default;
EgoMotion::EgoMotion(EgoMotion&&) noexcept = default;
EgoMotion& EgoMotion::operator=(EgoMotion&&) noexcept = default;

EgoMotionEstimate EgoMotion::estimate(const cv::Mat1b& left, const cv::Mat1b& right,
                                      const StereoRig& rig, const cv::Mat1b& moving_mask,
                                      const std::optional<Eigen::Matrix3d>& R_cam_prev) {
  return state_->estimate(left, right, rig, moving_mask, R_cam_prev);
}

void EgoMotion::setParams(const EgoMotionParams& params) { state_->setParams(params); }

void EgoMotion::reset() { state_->reset(); }

void EgoMotionFault::setExpectedMotion(EgoMotion& ego_motion, const Eigen::Isometry3d& T_cam_prev) {
  ego_motion.state_->T_last = T_cam_prev;
}

Eigen::Isometry3d EgoMotionFault::expectedMotion(const EgoMotion& ego_motion) {
  return ego_motion.state_->T_last;
}

}  // namespace predictive_stereo
