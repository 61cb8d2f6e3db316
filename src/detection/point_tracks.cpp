#include "detection/point_tracks.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "detection/motion_noise.h"
#include "imaging/tracking.h"

namespace predictive_stereo {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Variance of an error that all disparities share: calibration, row offsets.
constexpr double kDisparityBias_px2 = 0.5;
// Allowed difference between flows of one object.
constexpr double kFlowNoise_px = 1.5, kFlowShare = 0.3;
constexpr double kHuber = 2, kInlier = 5;  // standard deviations

// Derivative of (x, y, d) with respect to the point.
Matrix3d projectionJacobian(const StereoRig& rig, const Vector3d& p) {
  const double z = p.z();
  Matrix3d j;
  j << rig.fx_px / z, 0, -rig.fx_px * p.x() / (z * z),  //
      0, rig.fy_px / z, -rig.fy_px * p.y() / (z * z),   //
      0, 0, -rig.disparityTimesDepth() / (z * z);
  return j;
}

float disparityAt(const cv::Mat1f& map, const DisparityRange& range, const Vector3d& at) {
  const int x = cvRound(at.x()), y = cvRound(at.y());
  if (x < 0 || y < 0 || x >= map.cols || y >= map.rows || !range.isValid(map(y, x))) return -1;
  return map(y, x);
}

bool hasMoved(const PastView& view, const PointTrack& track) {
  const Matrix3d j = projectionJacobian(view.rig(), track.static_m);
  const Eigen::Vector3f farther =
      view.static_source(track.position.x, track.position.y, track.disparity_px + 0.1f);
  const Vector3d by_disparity = (farther.cast<double>() - track.static_px) / 0.1;
  Matrix3d covariance = by_disparity * by_disparity.transpose() * track.variance_px2;
  // An error that both frames share cancels in the disparity.
  const Vector3d by_bias(by_disparity.x(), by_disparity.y(), 0);
  covariance += by_bias * by_bias.transpose() * kDisparityBias_px2;
  covariance += j *
                pointCovariance(view.past.T_past_cam, view.past.motion_covariance, track.point_m) *
                j.transpose();
  const double flow = kFlowSigma_px * kFlowSigma_px;
  covariance.diagonal() +=
      Vector3d(flow, flow, kPreviousDisparitySigma_px * kPreviousDisparitySigma_px);
  Vector3d residual = track.found_px - track.static_px;
  if (track.found_px.z() < 0) {
    residual.z() = 0;
    covariance(2, 2) += 1e6;
  }
  return residual.dot(covariance.inverse() * residual) >= view.params().min_mahalanobis;
}

// The points with a disparity, and their expected positions if they are static.
std::vector<PointTrack> expectedTracks(const PastView& view,
                                       const std::vector<cv::Point>& points_px) {
  std::vector<PointTrack> tracks;
  for (cv::Point p : points_px) {
    const float d = view.disparity_px()(p);
    if (!view.isKnown(d) || !(d > 0)) continue;
    PointTrack track;
    track.position = p;
    track.disparity_px = d;
    track.variance_px2 =
        std::max(view.frame.input.measured_variance_px2(p), kLeastDisparityVariance_px2);
    track.point_m = view.rig().pointFromDisparity(p.x, p.y, d);
    track.static_m = view.past.T_past_cam * track.point_m;
    if (!(track.static_m.z() > 0.5)) continue;
    track.static_px = view.rig().disparityFromPoint(track.static_m);
    tracks.push_back(track);
  }
  return tracks;
}

}  // namespace

std::vector<PointTrack> followPoints(const PastView& view, const std::vector<cv::Point>& points_px,
                                     cv::Point2f shift_px) {
  const std::vector<PointTrack> expected = expectedTracks(view, points_px);
  std::vector<Track> tracks(expected.size());
  for (size_t i = 0; i < expected.size(); ++i) {
    tracks[i].origin = expected[i].position;
    tracks[i].position = shift_px + cv::Point2f(static_cast<float>(expected[i].static_px.x()),
                                                static_cast<float>(expected[i].static_px.y()));
  }
  trackPoints(view.images(), view.past_images(), tracks);
  std::vector<PointTrack> found;
  for (size_t i = 0; i < expected.size(); ++i) {
    if (!tracks[i].found) continue;
    found.push_back(expected[i]);
    Vector3d& at = found.back().found_px;
    at = Vector3d(tracks[i].position.x, tracks[i].position.y, 0);
    at.z() = disparityAt(view.past.frame->disparity_px, view.frame.range, at);
    found.back().moving = hasMoved(view, found.back());
  }
  return found;
}

bool Displacement::isSignificant(const MotionDetectionParams& params) const {
  return moved_m.dot(covariance.inverse() * moved_m) >= params.min_mahalanobis;
}

Displacement fitDisplacement(const PastView& view, const std::vector<PointTrack>& tracks) {
  const StereoRig& rig = view.rig();
  Displacement fit;
  // Start: the median displacement across the line of sight, which does not need a past disparity.
  for (int k = 0; k < 2; ++k) {
    std::vector<double> values;
    for (const PointTrack& track : tracks)
      values.push_back(-track.flow()[k] * track.static_m.z() / rig.fx_px);
    std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(values.size() / 2),
                     values.end());
    fit.moved_m[k] = values[values.size() / 2];
  }
  Matrix3d information = Matrix3d::Identity();
  double chi2 = 0;
  int count = 0;
  for (int iteration = 0; iteration < 8; ++iteration) {
    // A weak prior, for the motion along the line of sight.
    information = Matrix3d::Identity() / 9.0;
    Vector3d gradient = information * -fit.moved_m;
    chi2 = 0;
    count = 0;
    fit.inliers.clear();
    for (size_t i = 0; i < tracks.size(); ++i) {
      const PointTrack& track = tracks[i];
      const Vector3d before = track.static_m - fit.moved_m;
      if (!(before.z() > 0.5)) continue;
      Vector3d residual = track.found_px - rig.disparityFromPoint(before);
      const double flow_variance = kFlowSigma_px * kFlowSigma_px;
      Vector3d weight(
          1 / flow_variance, 1 / flow_variance,
          1 / (track.variance_px2 + kPreviousDisparitySigma_px * kPreviousDisparitySigma_px));
      if (track.found_px.z() < 0) weight.z() = residual.z() = 0;
      const double flow_error = residual.head<2>().norm() / kFlowSigma_px;
      const double disparity_error = std::abs(residual.z()) * std::sqrt(weight.z());
      if (flow_error < kInlier) fit.inliers.push_back(i);
      weight.head<2>() *= std::min(1.0, kHuber / std::max(flow_error, 1e-9));
      weight.z() *= std::min(1.0, kHuber / std::max(disparity_error, 1e-9));
      const Matrix3d j = -projectionJacobian(rig, before);
      information += j.transpose() * weight.asDiagonal() * j;
      gradient += j.transpose() * weight.asDiagonal() * residual;
      chi2 += residual.dot(weight.asDiagonal() * residual);
      count += 3;
    }
    const Vector3d step = information.ldlt().solve(gradient);
    fit.moved_m += step;
    if (step.norm() < 1e-4) break;
  }
  const double scale = count > 6 ? std::max(1.0, chi2 / (count - 3)) : 4.0;
  fit.covariance = scale * information.inverse();
  // Errors of neighbouring points are correlated, and all points share the error of the ego-motion.
  fit.covariance *= 4;
  Vector3d centre_m = Vector3d::Zero();
  for (const PointTrack& track : tracks)
    centre_m += track.point_m / static_cast<double>(tracks.size());
  fit.covariance += pointCovariance(view.past.T_past_cam, view.past.motion_covariance, centre_m);
  return fit;
}

std::vector<std::vector<PointTrack>> clusterTracks(const PastView& view,
                                                   const std::vector<PointTrack>& tracks) {
  struct Moving {
    const PointTrack* track;
    Eigen::Vector2d flow;
    double flow_length;
  };
  std::vector<Moving> moving;
  for (const PointTrack& track : tracks)
    if (track.moving) moving.push_back({&track, track.flow(), track.flow().norm()});
  std::vector<size_t> parent(moving.size());
  std::iota(parent.begin(), parent.end(), size_t{0});
  const auto root = [&](size_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  const MotionDetectionParams& params = view.params();
  const double linked_px = params.link_distance_m / view.rig().baseline_m;  // per px of disparity
  const double linked_depth =
      kLinkDepth * params.link_distance_m / view.rig().disparityTimesDepth();
  const auto areAlike = [&](const Moving& p, const Moving& q) {
    const double d = p.track->disparity_px, e = q.track->disparity_px, mean_d = 0.5 * (d + e);
    const cv::Point2f apart = p.track->position - q.track->position;
    const double reach_px = linked_px * mean_d;
    return apart.ddot(apart) <= reach_px * reach_px &&
           std::abs(d - e) <= 1.0 + linked_depth * mean_d * mean_d &&
           (p.flow - q.flow).norm() <=
               kFlowNoise_px + kFlowShare * std::max(p.flow_length, q.flow_length);
  };
  for (size_t a = 0; a < moving.size(); ++a)
    for (size_t b = a + 1; b < moving.size(); ++b)
      if (areAlike(moving[a], moving[b])) parent[root(a)] = root(b);
  std::vector<std::vector<PointTrack>> clusters(moving.size());
  for (size_t i = 0; i < moving.size(); ++i) clusters[root(i)].push_back(*moving[i].track);
  clusters.erase(std::remove_if(clusters.begin(), clusters.end(),
                                [&](const auto& cluster) {
                                  return static_cast<int>(cluster.size()) < params.min_tracks;
                                }),
                 clusters.end());
  std::stable_sort(clusters.begin(), clusters.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return clusters;
}

}  // namespace predictive_stereo
