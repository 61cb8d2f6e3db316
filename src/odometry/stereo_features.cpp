#include "odometry/stereo_features.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "imaging/tracking.h"

namespace predictive_stereo {
namespace {

constexpr int kLevels = 4;
constexpr int kBorderPx = 10;  // room for a patch with its gradients
// The relative variance of a coordinate is 1 (interpolation, depth within the patch: 0.07 px) plus
// this factor times its variance [px^2] for image noise of one grey level. Estimated on the scenes
// drone, robot and handheld.
constexpr double kNoiseVariance = 3000;
// Likelihood that a point is static: of a new point, of an inlier of the last motion, of an
// outlier.
constexpr double kNewTrust = 0.5, kStaticTrust = 1.0, kMovingTrust = 0.2;
constexpr int kSwappedShiftPx = 3;   // disparities below minus this mean swapped images
constexpr int kSwappedCorners = 30;  // if at least so many have them

// Relative variances of tracks and disparities, see Correspondence.
Eigen::Vector2d relativeVariance(const Track& track) {
  return {1 + kNoiseVariance * track.variance_px2[0], 1 + kNoiseVariance * track.variance_px2[1]};
}
double relativeVariance(const StereoMatch& match) {
  return 1 + kNoiseVariance * match.shift_variance_px2;
}

// Where features of a reference are expected.
struct ExpectedFeatures {
  std::vector<Track> tracks;        // `id` is the index of the feature
  std::vector<float> disparity_px;  // of each track
};

ExpectedFeatures expectFeatures(const ReferenceFrame& reference, const StereoRig& rig,
                                const Eigen::Isometry3d& T_expected, const cv::Mat1b& ignored_mask,
                                int max_disparity_px) {
  const Eigen::Matrix4d H = disparityMotion(rig, T_expected);
  const double offset_px = reference.offset.offset_px;
  const cv::Rect2d image(0, 0, rig.size.width, rig.size.height);
  ExpectedFeatures result;
  for (size_t i = 0; i < reference.features.size(); ++i) {
    const Feature& feature = reference.features[i];
    if (!ignored_mask.empty() && ignored_mask(cv::Point(feature.position))) continue;
    Track track;
    track.id = static_cast<int>(i);
    track.origin = track.position = feature.position;
    float disparity_px = feature.disparity_px;
    Eigen::Vector4d expected = H * Eigen::Vector4d(feature.position.x, feature.position.y,
                                                   feature.disparity_px + offset_px, 1);
    const double size_change = expected.w();  // current depth / reference depth
    expected /= expected.w();
    if (size_change > 0 && image.contains(cv::Point2d(expected.x(), expected.y())) &&
        expected.z() < max_disparity_px) {
      track.position = cv::Point2d(expected.x(), expected.y());
      track.scale = static_cast<float>(std::clamp(size_change, 0.6, 1.6));
      disparity_px = static_cast<float>(expected.z() - offset_px);
    }
    result.tracks.push_back(track);
    result.disparity_px.push_back(disparity_px);
  }
  return result;
}

}  // namespace

StereoFeatures::StereoFeatures(const EgoMotionParams& params)
    : params_(params), rows_{RowOffsetFilter(params.row_alignment), {}} {}

void StereoFeatures::setParams(const EgoMotionParams& params) {
  params_ = params;
  rows_.filter.setParams(params.row_alignment);
  if (!params.row_alignment.enabled) rows_.model = RowOffsetModel();
}

void StereoFeatures::reset() {
  rows_.filter.reset();
  rows_.model = RowOffsetModel();
}

void StereoFeatures::setPair(const cv::Mat1b& left, const cv::Mat1b& right, const StereoRig& rig) {
  rig_ = rig;
  left_.build(left, kLevels);
  right_.buildOn(right, 2);
}

FollowedFeatures StereoFeatures::follow(const ReferenceFrame& reference,
                                        const Eigen::Isometry3d& T_expected,
                                        const cv::Mat1b& ignored_mask) const {
  auto [tracks, expected_px] =
      expectFeatures(reference, rig_, T_expected, ignored_mask, params_.max_disparity_px);
  trackPoints(reference.left, left_, tracks);
  std::vector<StereoMatch> matches;
  for (size_t i = 0; i < tracks.size(); ++i) {
    if (!tracks[i].found) continue;
    StereoMatch match;
    match.id = static_cast<int>(i);
    match.point = tracks[i].position;
    match.expected = true;
    match.shift_px = expected_px[i] + static_cast<float>(rig_.principalOffset());
    matches.push_back(match);
  }
  findInRightImage(matches);

  FollowedFeatures followed;
  followed.rows = rows_;
  updateRows(matches, *followed.rows);
  followed.searched = static_cast<int>(tracks.size());
  for (const StereoMatch& match : matches) {
    const Track& track = tracks[match.id];
    const Feature& feature = reference.features[track.id];
    Correspondence c;
    c.previous << feature.position.x, feature.position.y, feature.disparity_px;
    c.current << match.point.x, match.point.y, disparity(match, followed.rows->model);
    c.track_variance = relativeVariance(track);
    c.previous_disparity_variance = feature.disparity_variance;
    c.current_disparity_variance = relativeVariance(match);
    c.trust = feature.trust;
    followed.correspondences.push_back(c);
  }
  return followed;
}

bool StereoFeatures::lookSwapped() {
  const std::vector<StereoMatch> corners = findCorners({});
  const auto found = [&](const StereoSearch& search) {
    std::vector<StereoMatch> matches = corners;
    matchStereo(left_, right_, RowOffsetModel(), search, matches);
    return std::count_if(matches.begin(), matches.end(),
                         [](const StereoMatch& match) { return match.found; });
  };
  const StereoSearch search = stereoSearch();
  StereoSearch swapped = search;
  swapped.largest_shift_px = -kSwappedShiftPx - cvFloor(rig_.principalOffset());
  swapped.smallest_shift_px = -search.largest_shift_px;
  const auto as_swapped = found(swapped);
  return as_swapped >= kSwappedCorners && as_swapped > 2 * found(search);
}

ReferenceFrame StereoFeatures::makeReference(const std::vector<Correspondence>& correspondences,
                                             const std::vector<char>& inlier) {
  ReferenceFrame here;
  std::vector<cv::Point2f> taken;
  for (size_t i = 0; i < correspondences.size(); ++i) {
    const Correspondence& c = correspondences[i];
    const cv::Point2f position = cv::Point2d(c.current.x(), c.current.y());
    here.features.push_back({position, static_cast<float>(c.current.z()),
                             c.current_disparity_variance,
                             inlier[i] ? kStaticTrust : kMovingTrust});
    taken.push_back(position);
  }
  std::vector<StereoMatch> corners = findCorners(taken);
  findInRightImage(corners);
  if (rows_.model.isIdentity()) updateRows(corners, rows_);
  for (const StereoMatch& match : corners)
    here.features.push_back(
        {match.point, disparity(match, rows_.model), relativeVariance(match), kNewTrust});
  std::swap(here.left, left_);
  return here;
}

// New corners between the points `taken`. They are not matched yet.
std::vector<StereoMatch> StereoFeatures::findCorners(const std::vector<cv::Point2f>& taken) {
  std::vector<cv::Point2f> corners;
  detector_.detect(left_.level(0), params_.features, taken, kBorderPx, corners);
  std::vector<StereoMatch> matches(corners.size());
  for (size_t i = 0; i < corners.size(); ++i) matches[i].point = corners[i];
  return matches;
}

StereoSearch StereoFeatures::stereoSearch() const {
  StereoSearch search;
  search.largest_shift_px =
      params_.max_disparity_px + static_cast<int>(std::ceil(rig_.principalOffset()));
  search.smallest_shift_px += static_cast<int>(std::floor(rig_.principalOffset()));
  return search;
}

// Removes the points that are not found.
void StereoFeatures::findInRightImage(std::vector<StereoMatch>& matches) const {
  StereoSearch search = stereoSearch();
  if (!rows_.model.isIdentity()) search.row_radius_px = 0;
  matchStereo(left_, right_, rows_.model, search, matches);
  matches.erase(std::remove_if(matches.begin(), matches.end(),
                               [](const StereoMatch& match) { return !match.found; }),
                matches.end());
}

void StereoFeatures::updateRows(const std::vector<StereoMatch>& matches, FeatureRows& rows) const {
  if (!params_.row_alignment.enabled) return;
  std::vector<RowOffsetMeasurement> samples;
  for (const StereoMatch& match : matches)
    samples.push_back({match.point.x - match.shift_px, match.point.y, match.row_offset_px});
  rows.model = rows.filter.update(samples, rig_.size);
}

float StereoFeatures::disparity(const StereoMatch& match, const RowOffsetModel& alignment) const {
  float shift_px = match.shift_px;
  if (!alignment.isIdentity()) {
    const auto row_offset = static_cast<float>(
        alignment.offset(match.point.x - match.shift_px, match.point.y, rig_.size));
    shift_px += match.shift_by_row * (match.row_offset_px - row_offset);
  }
  return shift_px - static_cast<float>(rig_.principalOffset());
}

}  // namespace predictive_stereo
