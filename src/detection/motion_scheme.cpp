#include "detection/motion_scheme.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "detection/displacement_search.h"
#include "detection/object_shape.h"

namespace predictive_stereo {
namespace {

constexpr int kPyramidLevels = 4;
constexpr double kFastest_mps = 55;
// What moves stands on the road: its foot is not seen higher than this, uphill included.
constexpr double kHighestFoot_m = 1.2, kRoadSlope = 0.03;

double dt(const RememberedFrame& previous, const DetectionInput& input) {
  return input.stamp_s - previous.stamp_s;
}

// Full-resolution pixels of a segment: its lattice cells, cut to the layer of the disparities.
ObservedObject observed(const DetectionInput& input, const Segment& segment, float nearest,
                        float farthest) {
  ObservedObject object;
  const cv::Rect image(cv::Point(), input.rig.size);
  const cv::Rect box = cv::Rect(2 * segment.area.x, 2 * segment.area.y, 2 * segment.area.width,
                                2 * segment.area.height) &
                       image;
  object.observation.box_px = box;
  object.mask = cv::Mat1b::zeros(box.size());
  for (int y = 0; y < box.height; ++y)
    for (int x = 0; x < box.width; ++x) {
      const float d = input.measured_disparity_px(box.y + y, box.x + x);
      if (segment.mask(y / 2, x / 2) && d >= farthest && d <= nearest) object.mask(y, x) = 255;
    }
  return object;
}

// Lattice points as pixels, evenly thinned.
std::vector<cv::Point> sampleOf(const std::vector<cv::Point>& lattice_points) {
  constexpr size_t kMost = 40;
  std::vector<cv::Point> pixels;
  const size_t step = lattice_points.size() / (kMost + 1) + 1;
  for (size_t i = 0; i < lattice_points.size(); i += step) pixels.push_back(2 * lattice_points[i]);
  return pixels;
}

// Whether something nearer covers the lower end of what is seen in a box.
bool hiddenBelow(const DetectionInput& input, float nearest_px, const cv::Rect& box) {
  constexpr int kBelow_px = 6;
  const int y = std::min(box.br().y + kBelow_px, input.rig.size.height - 1);
  int nearer = 0;
  for (int x = box.x; x < box.br().x; ++x) nearer += input.measured_disparity_px(y, x) > nearest_px;
  return 2 * nearer > box.width;
}

}  // namespace

// The disparities of the seeds, and a little beyond.
void MotionScheme::setLayer(const DetectionInput& input, Hypothesis& hypothesis) const {
  std::vector<float> values;
  for (cv::Point seed : hypothesis.seeds)
    values.push_back(input.measured_disparity_px(2 * seed.y, 2 * seed.x));
  std::sort(values.begin(), values.end());
  const auto quantile = [&](double share) {
    return values[static_cast<size_t>(share * static_cast<double>(values.size() - 1))];
  };
  hypothesis.disparity_px = quantile(0.5);
  const auto fB = static_cast<float>(input.rig.disparityTimesDepth());
  const auto margin_m = static_cast<float>(params_.layer_margin_m);
  constexpr float kNoise_px = 1.0f;
  hypothesis.nearest_px = fB / std::max(fB / quantile(0.9) - margin_m, 0.5f) + kNoise_px;
  hypothesis.farthest_px = fB / (fB / quantile(0.1) + margin_m) - kNoise_px;
}

void MotionScheme::remember(const DetectionInput& input) {
  current_.stamp_s = input.stamp_s;
  current_.has_pose = input.has_pose;
  current_.T_odom_cam = input.T_odom_cam;
  constexpr int kParts = 2;  // of about the same length
  cv::parallel_for_(cv::Range(0, kParts), [&](const cv::Range& parts) {
    for (int part = parts.start; part < parts.end; ++part)
      if (part == 0)
        current_.pyramid.build(input.left, kPyramidLevels);
      else
        input.measured_disparity_px.copyTo(current_.disparity_px);
  });
}

void MotionScheme::tryHypothesis(const DetectionInput& input, const Hypothesis& hypothesis,
                                 const Eigen::Matrix3d& covariance, bool dense, bool expected,
                                 std::vector<ObservedObject>& objects) {
  if (hypothesis.moved_m.norm() > kFastest_mps * dt(previous_, input)) return;
  int free = 0;
  for (cv::Point p : hypothesis.seeds) free += !taken_(p);
  if (2 * free < static_cast<int>(hypothesis.seeds.size())) return;
  const SegmentationView view{input.rig,
                              range_,
                              current_.pyramid,
                              previous_.pyramid,
                              input.measured_disparity_px,
                              T_prev_cam_,
                              static_world_.mismatch,
                              dense_residual_px_,
                              ground_};
  const auto found = segment(view, params_, hypothesis, segmentation_);
  if (!found) return;
  const bool explained =
      found->decisive >= params_.min_decisive_cells && found->explained >= params_.min_explained;
  const bool along = found->dense >= params_.dense_min_share &&
                     (found->explained >= 0.5 || found->decisive < params_.min_decisive_cells);
  if (!(explained || ((dense || expected) && along))) return;

  ObservedObject object = observed(input, *found, hypothesis.nearest_px, hypothesis.farthest_px);
  const double depth = input.rig.disparityTimesDepth() / hypothesis.disparity_px;
  Observation& seen = object.observation;
  const auto shape =
      shapeOf(input.rig, range_, input.measured_disparity_px, seen.box_px, object.mask);
  if (!shape) return;
  const double height = seen.box_px.height * shape->centre_m.z() / input.rig.fy_px;
  const double width = seen.box_px.width * shape->centre_m.z() / input.rig.fx_px;
  const bool cut_below = seen.box_px.br().y >= input.rig.size.height - 4;
  // Of what is half hidden its foot is not seen, and half of its height is enough.
  const bool stands = !cut_below && !hiddenBelow(input, hypothesis.nearest_px, seen.box_px);
  const double least_height = params_.min_height_m * (cut_below ? 0 : stands ? 1 : 0.5);
  if (height < least_height || height > params_.max_height_m || width > params_.max_width_m ||
      width < params_.min_width_m)
    return;
  if (stands && road_ &&
      road_->heightOf(seen.box_px.br().y, hypothesis.disparity_px, input.rig.baseline_m) >
          kHighestFoot_m + kRoadSlope * depth)
    return;
  // What overlaps an object of about the same depth belongs to it.
  for (const ObservedObject& other : objects) {
    const cv::Rect common = other.observation.box_px & seen.box_px;
    if (common.area() > 0.5 * std::min(other.observation.box_px.area(), seen.box_px.area()) &&
        std::abs(other.observation.distance_m - shape->distance_m) < params_.max_width_m / 2)
      return;
  }

  seen.centre_m = shape->centre_m;
  seen.size_m = shape->size_m;
  seen.distance_m = shape->distance_m;
  const double sigma_z = 0.3 + 0.3 * depth / hypothesis.disparity_px;
  seen.centre_covariance = Eigen::Vector3d(0.04, 0.04, sigma_z * sigma_z).asDiagonal();
  const double seconds = dt(previous_, input);
  if (!expected && seconds > 0) {
    const Eigen::Matrix3d R = previous_.T_odom_cam.linear();
    seen.has_velocity = true;
    seen.velocity_mps = R * hypothesis.moved_m / seconds;
    seen.velocity_covariance = R * covariance * R.transpose() / (seconds * seconds);
  }
  seen.score = std::clamp(explained ? found->explained : found->dense, 0.0, 1.0);
  for (int v = 0; v < found->area.height; ++v)
    for (int u = 0; u < found->area.width; ++u)
      if (found->mask(v, u)) taken_(found->area.y + v, found->area.x + u) = 255;
  objects.push_back(std::move(object));
}

void MotionScheme::observe(const DetectionInput& input, const ObjectTracker& known,
                           std::vector<ObservedObject>& objects) {
  remember(input);
  const bool comparable =
      !previous_.empty() && previous_.has_pose && input.has_pose && dt(previous_, input) > 0;
  if (comparable) {
    T_prev_cam_ = previous_.T_odom_cam.inverse() * input.T_odom_cam;
    const cv::Rect lattice(cv::Point(), current_.pyramid.level(1).size());
    const SourceOf source_of(disparityMotion(input.rig, T_prev_cam_));
    compareFrames(current_.pyramid, input.measured_disparity_px, range_, previous_.pyramid,
                  source_of, lattice, static_world_);
    denseResidual(input, range_, source_of, previous_.disparity_px, lattice.size(),
                  dense_residual_px_);
    taken_.create(lattice.size());
    taken_.setTo(0);
    if (const auto road = fitRoadLine(input.rig, range_, input.measured_disparity_px)) road_ = road;
    ground_.setFrame(input.rig, range_, input.measured_disparity_px);

    const TrackingView view{input.rig,
                            range_,
                            current_.pyramid,
                            input.measured_disparity_px,
                            input.measured_variance_px2,
                            previous_,
                            T_prev_cam_};
    const std::vector<PointTrack> tracks =
        followPoints(view, params_,
                     suspicion_.find(current_.pyramid.level(1), static_world_.mismatch,
                                     input.measured_disparity_px, ground_, params_));
    for (const auto& members : clusterTracks(input.rig, params_, tracks)) {
      const Displacement fit = fitDisplacement(input.rig, params_, tracks, members);
      if (static_cast<int>(fit.inliers.size()) < params_.min_tracks ||
          fit.moved_m.norm() < params_.min_displacement_m)
        continue;
      Hypothesis hypothesis;
      hypothesis.moved_m = fit.moved_m;
      for (size_t i : fit.inliers)
        hypothesis.seeds.emplace_back(static_cast<int>(tracks[i].position.x) / 2,
                                      static_cast<int>(tracks[i].position.y) / 2);
      setLayer(input, hypothesis);
      tryHypothesis(input, hypothesis, fit.covariance, false, false, objects);
    }

    for (const DenseGroup& group :
         dense_groups_.find(dense_residual_px_, input.measured_disparity_px, params_)) {
      const double pixels_per_m = group.disparity_px / input.rig.baseline_m;
      if (static_cast<double>(group.points.size()) * 4 / (pixels_per_m * pixels_per_m) <
          params_.dense_min_area_m2)
        continue;
      Hypothesis hypothesis;
      hypothesis.seeds = group.points;
      setLayer(input, hypothesis);
      const auto shift = searchShift(current_.pyramid, previous_.pyramid, source_of,
                                     input.measured_disparity_px, group.points);
      if (!shift) continue;
      const std::vector<PointTrack> followed =
          followPoints(view, params_, sampleOf(group.points), *shift);
      if (static_cast<int>(followed.size()) < params_.min_tracks) continue;
      std::vector<size_t> all(followed.size());
      for (size_t i = 0; i < all.size(); ++i) all[i] = i;
      const Displacement fit = fitDisplacement(input.rig, params_, followed, all);
      if (static_cast<int>(fit.inliers.size()) < params_.min_tracks ||
          fit.moved_m.norm() < params_.min_displacement_m)
        continue;
      hypothesis.moved_m = fit.moved_m;
      tryHypothesis(input, hypothesis, fit.covariance, true, false, objects);
    }

    // Objects that are known are looked for where they should be.
    for (const ObjectTrack& track : known.tracks()) {
      if (!track.confirmed) continue;
      const cv::Rect box = track.last.box_px & cv::Rect(cv::Point(), input.rig.size);
      if (box.area() < 100) continue;
      Hypothesis hypothesis;
      const double depth = track.last.centre_m.z();
      hypothesis.disparity_px = static_cast<float>(input.rig.disparityTimesDepth() / depth);
      hypothesis.moved_m =
          previous_.T_odom_cam.linear().transpose() * track.state.tail<3>() * dt(previous_, input);
      if (hypothesis.moved_m.norm() < params_.min_displacement_m) continue;
      const float tolerance = 1 + 0.15f * hypothesis.disparity_px;
      for (int v = box.y / 2 + box.height / 8; v < (box.br().y - box.height / 4) / 2; v += 2)
        for (int u = box.x / 2 + box.width / 10; u < (box.br().x - box.width / 5) / 2; u += 2)
          if (std::abs(input.measured_disparity_px(2 * v, 2 * u) - hypothesis.disparity_px) <
              tolerance)
            hypothesis.seeds.emplace_back(u, v);
      if (hypothesis.seeds.size() < 8) continue;
      setLayer(input, hypothesis);
      tryHypothesis(input, hypothesis, {}, false, true, objects);
    }
  }
  std::swap(previous_, current_);
}

}  // namespace predictive_stereo
