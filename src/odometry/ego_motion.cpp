#include "predictive_stereo/ego_motion.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "odometry/features.h"
#include "odometry/image_pyramid.h"
#include "odometry/pose_solver.h"
#include "odometry/row_offset.h"
#include "odometry/stereo_depth.h"
#include "odometry/tracking.h"

namespace predictive_stereo {
namespace {

constexpr int kLevels = 4;
constexpr int kBorderPx = 10;             // a patch with its gradients fits in
constexpr double kExpectedSigmaPx = 0.3;  // of a coordinate, before the first measurement of it
constexpr double kLostCovariance = 9999;
constexpr double kNewTrust = 0.5, kStaticTrust = 1.0, kMovingTrust = 0.2;

void requireSize(const char* name, const cv::Mat1b& image, cv::Size size) {
  const auto text = [](cv::Size s) {
    return std::to_string(s.width) + "x" + std::to_string(s.height);
  };
  if (image.size() != size)
    throw std::invalid_argument(std::string("ego-motion: the ") + name + " is " +
                                text(image.size()) + ", the rig's images are " + text(size) +
                                "; do the camera_info topics belong to these images?");
}

// A corner of a frame, with its depth.
struct Feature {
  cv::Point2f position;
  float disparity_px = 0;
  double trust = kNewTrust;
};

struct Frame {
  ImagePyramid left;
  std::vector<Feature> features;
};

}  // namespace

struct EgoMotion::State {
  explicit State(const EgoMotionParams& p) : params(p) { validate(p, "ego_motion/"); }

  EgoMotionEstimate estimate(const cv::Mat1b& left, const cv::Mat1b& right,
                             const StereoRig& new_rig, const cv::Mat1b& moving_mask);
  void reset();

  void predictTracks(const cv::Mat1b& moving_mask);
  void matchTracks();
  void updateRowAlignment();
  float disparity(cv::Point2f position, const StereoMatch& match) const;
  PoseSolution solve();
  void replaceReference(const PoseSolution& solution);

  EgoMotionParams params;
  StereoRig rig;
  Frame reference;                           // the last frame that was not lost
  ImagePyramid left_pyramid, right_pyramid;  // of the current one
  RowAlignment alignment;
  Eigen::Isometry3d T_last = Eigen::Isometry3d::Identity();  // the motion expected next

  CornerDetector detector;
  // One entry per feature of the reference that is followed.
  std::vector<cv::Point2f> origins, positions;
  std::vector<Track> tracks;
  std::vector<StereoMatch> matches;
  std::vector<Correspondence> correspondences;
  std::vector<int> track_of_correspondence;
  std::vector<double> trusts;
  std::vector<float> reference_disparities;
};

void EgoMotion::State::reset() {
  reference.features.clear();
  reference.left = {};
  alignment = {};
  T_last = Eigen::Isometry3d::Identity();
}

// Where the features are expected if the camera goes on as it did.
void EgoMotion::State::predictTracks(const cv::Mat1b& moving_mask) {
  const Eigen::Matrix4d H = disparityMotion(rig, T_last);
  origins.clear();
  tracks.clear();
  matches.clear();
  trusts.clear();
  reference_disparities.clear();
  for (const Feature& feature : reference.features) {
    if (!moving_mask.empty() && moving_mask(cv::Point(feature.position))) continue;
    Eigen::Vector4d expected =
        H * Eigen::Vector4d(feature.position.x, feature.position.y, feature.disparity_px, 1);
    expected /= expected.w();
    Track track;
    StereoMatch match;
    track.position = feature.position;
    match.shift_px = feature.disparity_px;
    if (expected.allFinite() && expected.w() > 0 && expected.z() < params.max_disparity_px &&
        cv::Rect2f(0, 0, static_cast<float>(rig.size.width), static_cast<float>(rig.size.height))
            .contains(cv::Point2d(expected.x(), expected.y()))) {
      track.position = cv::Point2d(expected.x(), expected.y());
      match.shift_px = static_cast<float>(expected.z());
    }
    match.shift_px += static_cast<float>(rig.cx_left_px - rig.cx_right_px);
    match.expected = true;
    origins.push_back(feature.position);
    tracks.push_back(track);
    matches.push_back(match);
    trusts.push_back(feature.trust);
    reference_disparities.push_back(feature.disparity_px);
  }
}

// Follows the features, then finds them in the right image; forgets those that are not found.
void EgoMotion::State::matchTracks() {
  trackPoints(reference.left, left_pyramid, origins, tracks);
  size_t kept = 0;
  positions.clear();
  for (size_t i = 0; i < tracks.size(); ++i) {
    if (!tracks[i].found) continue;
    positions.push_back(tracks[i].position);
    origins[kept] = origins[i];
    tracks[kept] = tracks[i];
    matches[kept] = matches[i];
    trusts[kept] = trusts[i];
    reference_disparities[kept] = reference_disparities[i];
    ++kept;
  }
  origins.resize(kept);
  tracks.resize(kept);
  matches.resize(kept);
  trusts.resize(kept);
  reference_disparities.resize(kept);
  StereoSearch search;
  search.largest_shift_px = params.max_disparity_px;
  matchStereo(left_pyramid, right_pyramid, alignment, search, positions, matches);
}

void EgoMotion::State::updateRowAlignment() {
  if (!params.row_alignment.enabled) return;
  std::vector<RowOffsetSample> samples;
  for (size_t i = 0; i < matches.size(); ++i)
    if (matches[i].found) samples.push_back({positions[i], matches[i].row_offset_px});
  alignment = fitRowOffset(samples, rig.size, alignment, params.row_alignment);
}

float EgoMotion::State::disparity(cv::Point2f position, const StereoMatch& match) const {
  const float row_offset = rowOffset(alignment, position, rig.size);
  return match.shift_px + match.shift_by_row * (match.row_offset_px - row_offset) -
         static_cast<float>(rig.cx_left_px - rig.cx_right_px);
}

PoseSolution EgoMotion::State::solve() {
  correspondences.clear();
  track_of_correspondence.clear();
  for (size_t i = 0; i < matches.size(); ++i) {
    if (!matches[i].found) continue;
    Correspondence c;
    c.previous << origins[i].x, origins[i].y, reference_disparities[i];
    c.current << positions[i].x, positions[i].y, disparity(positions[i], matches[i]);
    c.trust = trusts[i];
    correspondences.push_back(c);
    track_of_correspondence.push_back(static_cast<int>(i));
  }
  return solvePose(rig, correspondences, T_last, kExpectedSigmaPx, PoseSolverParams());
}

// Makes the current frame the reference: its tracks go on, new corners fill the gaps.
void EgoMotion::State::replaceReference(const PoseSolution& solution) {
  reference.features.clear();
  std::vector<cv::Point2f> taken;
  for (size_t k = 0; k < correspondences.size(); ++k) {
    const Correspondence& c = correspondences[k];
    Feature feature;
    feature.position = cv::Point2d(c.current.x(), c.current.y());
    feature.disparity_px = static_cast<float>(c.current.z());
    feature.trust = solution.inlier.empty() ? kNewTrust
                    : solution.inlier[k]    ? kStaticTrust
                                            : kMovingTrust;
    reference.features.push_back(feature);
    taken.push_back(feature.position);
  }
  positions.clear();
  detector.detect(left_pyramid.level(0), params.features, taken, kBorderPx, positions);
  matches.assign(positions.size(), StereoMatch());
  StereoSearch search;
  search.largest_shift_px = params.max_disparity_px;
  matchStereo(left_pyramid, right_pyramid, alignment, search, positions, matches);
  if (alignment.isIdentity()) updateRowAlignment();
  for (size_t i = 0; i < positions.size(); ++i)
    if (matches[i].found)
      reference.features.push_back({positions[i], disparity(positions[i], matches[i]), kNewTrust});
  std::swap(reference.left, left_pyramid);
}

EgoMotionEstimate EgoMotion::State::estimate(const cv::Mat1b& left, const cv::Mat1b& right,
                                             const StereoRig& new_rig,
                                             const cv::Mat1b& moving_mask) {
  requireSize("left image", left, new_rig.size);
  requireSize("right image", right, new_rig.size);
  if (!moving_mask.empty()) requireSize("mask of moving objects", moving_mask, new_rig.size);
  if (new_rig != rig) reset();
  rig = new_rig;

  left_pyramid.build(left, kLevels);
  right_pyramid.build(right, 2);

  EgoMotionEstimate estimate;
  correspondences.clear();
  PoseSolution solution;
  if (reference.left.empty()) {
    estimate.status = EgoMotionStatus::kFirstFrame;
  } else {
    predictTracks(moving_mask);
    matchTracks();
    updateRowAlignment();
    solution = solve();
    estimate.features = static_cast<int>(correspondences.size());
    estimate.inliers = solution.inliers;
    estimate.residual_px = solution.residual_px;
    if (solution.found) {
      estimate.status = EgoMotionStatus::kTracked;
      estimate.motion.T_cam_prev = solution.T_cam_prev;
      estimate.motion.covariance = solution.covariance;
      T_last = solution.T_cam_prev;
    } else {
      estimate.status = EgoMotionStatus::kLost;
      estimate.motion.covariance = Matrix6d::Identity() * kLostCovariance;
      T_last = Eigen::Isometry3d::Identity();
    }
  }
  replaceReference(solution);
  estimate.row_alignment = alignment;
  return estimate;
}

EgoMotion::EgoMotion(const EgoMotionParams& params) : state_(std::make_unique<State>(params)) {}
EgoMotion::~EgoMotion() = default;
EgoMotion::EgoMotion(EgoMotion&&) noexcept = default;
EgoMotion& EgoMotion::operator=(EgoMotion&&) noexcept = default;

EgoMotionEstimate EgoMotion::estimate(const cv::Mat1b& left, const cv::Mat1b& right,
                                      const StereoRig& rig, const cv::Mat1b& moving_mask) {
  return state_->estimate(left, right, rig, moving_mask);
}

void EgoMotion::reset() { state_->reset(); }

}  // namespace predictive_stereo
