#include "detection/point_tracks.h"

#include <algorithm>
#include <cmath>

#include "detection/constants.h"
#include "detection/displacement_search.h"
#include "detection/motion_noise.h"
#include "imaging/tracking.h"

namespace predictive_stereo {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

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
  covariance += by_bias * by_bias.transpose() * kBothFrames_px2;
  covariance += j *
                pointCovariance(view.past.T_past_cam, view.past.motion_covariance, track.point_m) *
                j.transpose();
  const double flow = kFlowSigma_px * kFlowSigma_px;
  covariance.diagonal() += Vector3d(flow, flow, kDisparitySigma_px * kDisparitySigma_px);
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
    track.variance_px2 = std::max(view.frame.input.measured_variance_px2(p),
                                  kDisparitySigma_px * kDisparitySigma_px);
    track.point_m = view.rig().pointFromDisparity(p.x, p.y, d);
    track.static_m = view.past.T_past_cam * track.point_m;
    if (!(track.static_m.z() > 0.5)) continue;
    track.static_px = view.rig().disparityFromPoint(track.static_m);
    tracks.push_back(track);
  }
  return tracks;
}

// Robust fit of the translation of these points.
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
    information = Matrix3d::Identity() / (kPriorMotion_m * kPriorMotion_m);
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
      Vector3d weight(1 / flow_variance, 1 / flow_variance,
                      1 / (track.variance_px2 + kDisparitySigma_px * kDisparitySigma_px));
      if (track.found_px.z() < 0) weight.z() = residual.z() = 0;
      const double flow_error = residual.head<2>().norm() / kFlowSigma_px;
      const double disparity_error = std::abs(residual.z()) * std::sqrt(weight.z());
      if (flow_error < kInlierSigmas) fit.inliers.push_back(i);
      weight.head<2>() *= std::min(1.0, kSigmas / std::max(flow_error, 1e-9));
      weight.z() *= std::min(1.0, kSigmas / std::max(disparity_error, 1e-9));
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
  // All points share the error of the ego-motion.
  fit.covariance *= kCorrelation;
  Vector3d centre_m = Vector3d::Zero();
  for (const PointTrack& track : tracks)
    centre_m += track.point_m / static_cast<double>(tracks.size());
  fit.covariance += pointCovariance(view.past.T_past_cam, view.past.motion_covariance, centre_m);
  return fit;
}

// An even sample of lattice points, as pixels.
std::vector<cv::Point> sampleOf(const std::vector<cv::Point>& lattice_points) {
  constexpr size_t kMost = 40;
  std::vector<cv::Point> pixels;
  const size_t step = lattice_points.size() / (kMost + 1) + 1;
  for (size_t i = 0; i < lattice_points.size(); i += step) pixels.push_back(2 * lattice_points[i]);
  return pixels;
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

std::optional<Displacement> significantMotion(const PastView& view,
                                              const std::vector<PointTrack>& tracks) {
  const auto fewest = static_cast<size_t>(view.params().min_tracks);
  if (tracks.size() < fewest) return std::nullopt;
  Displacement motion = fitDisplacement(view, tracks);
  const double distance2 = motion.moved_m.dot(motion.covariance.inverse() * motion.moved_m);
  if (motion.inliers.size() < fewest || !(distance2 >= view.params().min_mahalanobis))
    return std::nullopt;
  return motion;
}

std::optional<Displacement> significantMotion(const PastView& view,
                                              const std::vector<cv::Point>& lattice_points) {
  const auto shift = searchShift(view, lattice_points);
  if (!shift) return std::nullopt;
  return significantMotion(view, followPoints(view, sampleOf(lattice_points), shift->shift_px));
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
  const MotionDetectionParams& params = view.params();
  const double linked_px = params.link_distance_m / view.rig().baseline_m;  // per px of disparity
  const double linked_depth =
      kLinkDepth * params.link_distance_m / view.rig().disparityTimesDepth();
  const auto areAlike = [&](const Moving& p, const Moving& q) {
    const double d = p.track->disparity_px, e = q.track->disparity_px, mean_d = 0.5 * (d + e);
    const cv::Point2f apart = p.track->position - q.track->position;
    const double reach_px = linked_px * mean_d;
    return apart.ddot(apart) <= reach_px * reach_px &&
           std::abs(d - e) <= kDisparityError_px + linked_depth * mean_d * mean_d &&
           (p.flow - q.flow).norm() <=
               kFlowNoise_px + kFlowShare * std::max(p.flow_length, q.flow_length);
  };
  std::vector<int> labels;
  std::vector<std::vector<PointTrack>> clusters(
      static_cast<size_t>(cv::partition(moving, labels, areAlike)));
  for (size_t i = 0; i < moving.size(); ++i)
    clusters[static_cast<size_t>(labels[i])].push_back(*moving[i].track);
  clusters.erase(std::remove_if(clusters.begin(), clusters.end(),
                                [&](const auto& cluster) {
                                  return static_cast<int>(cluster.size()) < params.min_tracks;
                                }),
                 clusters.end());
  std::stable_sort(clusters.begin(), clusters.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return clusters;
}

void setLayer(const FrameView& frame, Hypothesis& hypothesis) {
  std::vector<float> values;
  for (cv::Point seed : hypothesis.seeds)
    values.push_back(frame.input.measured_disparity_px(2 * seed.y, 2 * seed.x));
  const auto quantile = [&](double share) {
    const auto at = values.begin() +
                    static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return *at;
  };
  hypothesis.disparity_px = quantile(0.5);
  const auto fB = static_cast<float>(frame.input.rig.disparityTimesDepth());
  const auto margin_m = static_cast<float>(frame.params.layer_margin_m);
  hypothesis.nearest_px = fB / std::max(fB / quantile(0.9) - margin_m, 0.5f) + kDisparityError_px;
  hypothesis.farthest_px = std::max(fB / (fB / quantile(0.1) + margin_m) - kDisparityError_px,
                                    static_cast<float>(frame.range.min_disparity));
}

std::optional<Hypothesis> hypothesisOf(const PastView& view, const ObjectTrack& known) {
  const StereoRig& rig = view.rig();
  const cv::Rect box = known.last.box_px & cv::Rect(cv::Point(), rig.size);
  Hypothesis hypothesis;
  hypothesis.source = Hypothesis::Source::kKnown;
  hypothesis.disparity_px = static_cast<float>(rig.disparityTimesDepth() / known.last.centre_m.z());
  const Eigen::Vector3d velocity_mps = known.state.tail<3>();
  hypothesis.moved_m =
      view.past.frame->T_odom_cam.linear().transpose() * velocity_mps * view.past.seconds;
  const float tolerance = kDisparityError_px + kKnownDepth * hypothesis.disparity_px;
  const int across = static_cast<int>(kEndsAcross * box.width),
            down = static_cast<int>(kEndsDown * box.height);
  for (int v = (box.y + down) / 2; v < (box.br().y - down) / 2; v += 2)
    for (int u = (box.x + across) / 2; u < (box.br().x - across) / 2; u += 2) {
      const float d = view.disparity_px()(2 * v, 2 * u);
      if (view.isKnown(d) && std::abs(d - hypothesis.disparity_px) < tolerance)
        hypothesis.seeds.emplace_back(u, v);
    }
  if (hypothesis.seeds.empty()) return std::nullopt;
  setLayer(view.frame, hypothesis);
  return hypothesis;
}

}  // namespace predictive_stereo
