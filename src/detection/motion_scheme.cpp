#include "detection/motion_scheme.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "detection/displacement_search.h"
#include "detection/object_shape.h"
#include "detection/suspect_groups.h"
#include "detection/unexplained_points.h"

namespace predictive_stereo {
namespace {

constexpr int kPyramidLevels = 4;
constexpr double kFastest_mps = 55;
// What moves stands on the road: its foot is not seen higher than this, uphill included.
constexpr double kHighestFoot_m = 1.2, kRoadSlope = 0.03;
// What is slow is compared with frames so far back, as far as static points have not moved more.
constexpr size_t kFramesBack[] = {8, 6, 4, 2};
static_assert(kFramesBack[0] == MotionScheme::kFarthestPast);
constexpr double kMostParallax_px = 16;
// A wrong pose moves everything at once. What covers the image suddenly, or nearly all of it, is
// taken for that, in so many frames in a row; half of a view that moves for longer is believed.
constexpr double kMostOfTheImage = 0.8, kSuddenShare = 0.2;
constexpr int kMostOddFrames = 2;
// Of a slow object: how much better its motion explains the disparities of the past, what it leaves
// unexplained, and the share of them that tells; see LayerMotion.
constexpr double kLeastSlowGain = 1, kMostSlowCost = 4, kLeastKnown = 0.25;
constexpr int kMostSlowFits = 6;  // a frame, of the largest groups: they take 0.3 ms each
// Of one whose points are found again: squared ratio of its way to its error, and of the errors by
// which the way to the frame halfway may differ; 40 m/s.
constexpr double kLeastSlowWay = 16, kMostSlowDeviation = 12, kLargestSpeed_mps = 40;
constexpr float kLeastSlowDisparity_px = 10;  // errors are too large a share of smaller ones
constexpr int kLeastContrast_grey = 6;        // over 3x3 points that can be found again
constexpr double kLargestPart = 0.25;         // of the area of the object that it is a part of

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

// Whether something nearer that is not the ground covers the lower end of what is seen in a box.
bool hiddenBelow(const DetectionInput& input, const DisparityRange& range,
                 const LevelGround& ground, float nearest_px, float disparity_px,
                 const cv::Rect& box) {
  constexpr double kBelow_m = 0.3;
  constexpr int kLeastBelow_px = 6;
  const int below =
      std::max(kLeastBelow_px, static_cast<int>(kBelow_m * disparity_px / input.rig.baseline_m));
  const int end = std::min(box.br().y + below, input.rig.size.height - 1);
  int nearer = 0;
  for (int x = box.x / 2; x < box.br().x / 2; ++x)
    for (int y = (box.br().y + 1) / 2; y <= end / 2; ++y) {
      const float d = input.measured_disparity_px(2 * y, 2 * x);
      if (!range.isValid(d) || d <= nearest_px || ground.isLevel({x, y})) continue;
      ++nearer;
      break;
    }
  return 4 * nearer > box.width;
}

std::vector<size_t> allOf(const std::vector<PointTrack>& tracks) {
  std::vector<size_t> all(tracks.size());
  std::iota(all.begin(), all.end(), size_t{0});
  return all;
}

// Whether most of the points lie on something that can be found again.
bool hasTexture(const cv::Mat1b& image, const std::vector<cv::Point>& points) {
  int textured = 0;
  for (cv::Point p : points) {
    int darkest = 255, brightest = 0;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const int grey =
            image(std::clamp(p.y + dy, 0, image.rows - 1), std::clamp(p.x + dx, 0, image.cols - 1));
        darkest = std::min(darkest, grey);
        brightest = std::max(brightest, grey);
      }
    textured += brightest - darkest >= kLeastContrast_grey;
  }
  return 3 * textured >= static_cast<int>(points.size());
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
  std::rotate(frames_.begin(), frames_.end() - 1, frames_.end());
  RememberedFrame& current = frames_[0];
  current.stamp_s = input.stamp_s;
  current.has_pose = input.has_pose;
  current.follows = true;
  current.T_odom_cam = input.T_odom_cam;
  constexpr int kParts = 2;  // of about the same length
  cv::parallel_for_(cv::Range(0, kParts), [&](const cv::Range& parts) {
    for (int part = parts.start; part < parts.end; ++part)
      if (part == 0)
        current.pyramid.build(input.left, kPyramidLevels);
      else
        input.measured_disparity_px.copyTo(current.disparity_px);
  });
}

void MotionScheme::reset() {
  for (RememberedFrame& frame : frames_) frame = RememberedFrame();
  road_.reset();
  usual_share_.reset();
  odd_frames_ = 0;
}

// Whether the image agrees with the motion since the frame before, as far as it usually does.
bool MotionScheme::poseFollows() {
  const double share = suspicion_.share();
  const bool odd =
      share > kMostOfTheImage || (usual_share_ && share > *usual_share_ + kSuddenShare);
  if (odd && odd_frames_ < kMostOddFrames) {
    ++odd_frames_;
    return false;
  }
  odd_frames_ = 0;
  usual_share_ = share;
  return true;
}

// Frames before the current one, the last first, as far as poses and stamps go on.
std::vector<PastFrame> MotionScheme::pastOf(const DetectionInput& input) const {
  std::vector<PastFrame> past;
  for (size_t k = 1; k < frames_.size(); ++k) {
    const RememberedFrame& frame = frames_[k];
    if (frame.empty() || !input.has_pose || !frame.has_pose || !frames_[k - 1].follows ||
        !(frame.stamp_s < frames_[k - 1].stamp_s))
      break;
    past.push_back(
        {&frame, frame.T_odom_cam.inverse() * input.T_odom_cam, input.stamp_s - frame.stamp_s});
  }
  return past;
}

TrackingView MotionScheme::trackingView(const DetectionInput& input, const PastFrame& past) const {
  return {input.rig,
          range_,
          frames_[0].pyramid,
          input.measured_disparity_px,
          input.measured_variance_px2,
          *past.frame,
          past.T_past_cam};
}

// Whether most of it is no part of an object that was found already.
bool MotionScheme::isFree(const Hypothesis& hypothesis) const {
  int free = 0;
  for (cv::Point p : hypothesis.seeds) free += !taken_(p);
  return 2 * free >= static_cast<int>(hypothesis.seeds.size());
}

// Whether it goes on where an object of the same velocity ends, as the side of a vehicle does whose
// rear was found, or lies behind an object, where the past was hidden.
bool MotionScheme::belongsToAny(const Observation& seen, double largest_share,
                                const std::vector<ObservedObject>& objects) const {
  constexpr double kSigma_mps = 2, kMostSigmas = 3;  // of a side that slides along itself
  constexpr double kDepthGap_m = 4.5, kMostHidden = 0.3;
  for (const ObservedObject& object : objects) {
    const Observation& other = object.observation;
    const int gap_px = static_cast<int>(params_.gap_m / other.size_m.x() * other.box_px.width) + 8;
    const cv::Rect around(other.box_px.x - gap_px, other.box_px.y - gap_px,
                          other.box_px.width + 2 * gap_px, other.box_px.height + 2 * gap_px);
    if ((around & seen.box_px).empty()) continue;
    if (seen.size_m.x() * seen.size_m.y() > largest_share * other.size_m.x() * other.size_m.y())
      continue;
    const int common = (other.box_px & seen.box_px).area();
    if (common > kMostHidden * seen.box_px.area() && other.distance_m < seen.distance_m)
      return true;
    const double depth_gap_m = std::max(seen.distance_m - (other.distance_m + other.size_m.z()),
                                        other.distance_m - (seen.distance_m + seen.size_m.z()));
    if (depth_gap_m > kDepthGap_m) continue;
    if (!seen.has_velocity || !other.has_velocity) return true;
    const Eigen::Matrix3d covariance = seen.velocity_covariance + other.velocity_covariance +
                                       kSigma_mps * kSigma_mps * Eigen::Matrix3d::Identity();
    const Eigen::Vector3d difference = seen.velocity_mps - other.velocity_mps;
    if (difference.dot(covariance.inverse() * difference) < kMostSigmas * kMostSigmas) return true;
  }
  return false;
}

void MotionScheme::tryHypothesis(const DetectionInput& input, const Baseline& baseline,
                                 const Hypothesis& hypothesis, const Eigen::Matrix3d& covariance,
                                 Source source, std::vector<ObservedObject>& objects) {
  if (hypothesis.moved_m.norm() > kFastest_mps * baseline.past.seconds) return;
  if (!isFree(hypothesis)) return;
  const SegmentationView view{input.rig,
                              range_,
                              frames_[0].pyramid,
                              baseline.past.frame->pyramid,
                              input.measured_disparity_px,
                              baseline.past.T_past_cam,
                              baseline.past.frame->disparity_px,
                              baseline.past.seconds,
                              baseline.static_world.mismatch,
                              baseline.residual_px,
                              ground_,
                              source == Source::kSlow ? &*history_ : nullptr};
  const auto found = segment(view, params_, hypothesis, segmentation_);
  if (!found) return;
  const bool explained =
      found->decisive >= params_.min_decisive_cells && found->explained >= params_.min_explained;
  const bool along = found->dense >= params_.dense_min_share &&
                     (found->explained >= 0.5 || found->decisive < params_.min_decisive_cells);
  if (!(explained || (source != Source::kTracks && along))) return;

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
  const bool stands = !cut_below && !hiddenBelow(input, range_, ground_, hypothesis.nearest_px,
                                                 hypothesis.disparity_px, seen.box_px);
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
  if (source != Source::kKnown) {
    const double seconds = baseline.past.seconds;
    const Eigen::Matrix3d R = baseline.past.frame->T_odom_cam.linear();
    seen.has_velocity = true;
    seen.velocity_mps = R * hypothesis.moved_m / seconds;
    seen.velocity_covariance = R * covariance * R.transpose() / (seconds * seconds);
  }
  // Points of one frame tell velocities well enough to keep neighbours apart, but not from a part.
  const bool weak = source == Source::kKnown || source == Source::kSlow;
  if (belongsToAny(seen, weak ? std::numeric_limits<double>::infinity() : kLargestPart, objects))
    return;
  seen.score = std::clamp(explained ? found->explained : found->dense, 0.0, 1.0);
  for (int v = 0; v < found->area.height; ++v)
    for (int u = 0; u < found->area.width; ++u)
      if (found->mask(v, u)) taken_(found->area.y + v, found->area.x + u) = 255;
  objects.push_back(std::move(object));
}

void MotionScheme::findAcross(const DetectionInput& input, const Baseline& baseline,
                              const std::vector<cv::Point>& suspects_px,
                              std::vector<ObservedObject>& objects) {
  const TrackingView view = trackingView(input, baseline.past);
  unexplainedPoints(view, params_, baseline.past.seconds, suspects_px, unexplained_px_);
  const std::vector<PointTrack> tracks = followGroups(
      view, params_, groupSuspects(view, params_, unexplained_px_, baseline.past.seconds));
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
    tryHypothesis(input, baseline, hypothesis, fit.covariance, Source::kTracks, objects);
  }
}

// Whether what moved so since the far past did its share of it since the frame halfway, and whether
// the way is longer than errors are.
bool MotionScheme::goesOn(const DetectionInput& input, const std::vector<cv::Point>& points_px,
                          cv::Point2f shift_px, const Displacement& fit) const {
  const PastFrame &past = long_.past, &halfway = long_.halfway;
  if (fit.moved_m.norm() > kLargestSpeed_mps * past.seconds) return false;
  if (fit.moved_m.dot(fit.covariance.inverse() * fit.moved_m) < kLeastSlowWay) return false;
  const double share = halfway.seconds / past.seconds;
  const auto tracks = followPoints(trackingView(input, halfway), params_, points_px,
                                   static_cast<float>(share) * shift_px);
  if (static_cast<int>(tracks.size()) < params_.min_tracks) return false;
  const Displacement half = fitDisplacement(input.rig, params_, tracks, allOf(tracks));
  if (static_cast<int>(half.inliers.size()) < params_.min_tracks) return false;
  const Eigen::Matrix3d R = (past.T_past_cam * halfway.T_past_cam.inverse()).linear();
  const Eigen::Vector3d difference = R * half.moved_m - share * fit.moved_m;
  const Eigen::Matrix3d covariance =
      R * half.covariance * R.transpose() + share * share * fit.covariance;
  return difference.dot(covariance.inverse() * difference) < kMostSlowDeviation;
}

void MotionScheme::findAlong(const DetectionInput& input, const Baseline& baseline,
                             std::vector<ObservedObject>& objects) {
  // So far away that such a residual would be faster than anything on a road.
  const double farthest_px =
      std::sqrt(input.rig.disparityTimesDepth() * params_.dense_min_residual_px /
                (kLargestSpeed_mps * baseline.past.seconds));
  for (const DenseGroup& group :
       dense_groups_.find(baseline.residual_px, input.measured_disparity_px, params_))
    if (group.disparity_px >= farthest_px) tryGroup(input, group, baseline, objects);
}

void MotionScheme::findSlow(const DetectionInput& input, std::vector<ObservedObject>& objects) {
  longResidual(input.rig, input.measured_disparity_px, range_, pairs_, kMostParallax_px,
               frames_[0].pyramid.level(1).size(), long_.residual_px, pair_);
  int fits = 0;
  for (const DenseGroup& group :
       dense_groups_.findSlow(long_.residual_px, pair_, input.measured_disparity_px, params_)) {
    if (group.disparity_px < kLeastSlowDisparity_px) continue;
    if (!hasTexture(frames_[0].pyramid.level(1), group.points)) continue;
    // What comes towards the camera grows too much to be found again over the longest time.
    const size_t before = objects.size();
    for (size_t k = pair_(group.points.front()); k < pairs_.size() && objects.size() == before;
         ++k) {
      long_.past = pairs_[k].past;
      long_.halfway = pairs_[k].halfway;
      tryGroup(input, group, long_, objects);
    }
    if (objects.size() > before || fits == kMostSlowFits) continue;
    Hypothesis hypothesis;
    hypothesis.seeds = group.points;
    if (!isFree(hypothesis)) continue;
    setLayer(input, hypothesis);
    ++fits;
    trySlow(input, hypothesis, {}, objects);
  }
}

// What disparities of several frames say that it moves.
bool MotionScheme::trySlow(const DetectionInput& input, Hypothesis hypothesis,
                           const std::optional<Eigen::Vector3d>& expected_mps,
                           std::vector<ObservedObject>& objects) {
  std::vector<cv::Point> points = sampleOf(hypothesis.seeds);
  points.erase(
      std::remove_if(points.begin(), points.end(),
                     [&](cv::Point p) {
                       return std::abs(input.measured_disparity_px(p) - hypothesis.disparity_px) >
                              1 + 0.05f * hypothesis.disparity_px;
                     }),
      points.end());
  const auto motion = history_->fit(points, expected_mps);
  if (!motion) return false;
  // Images are compared over a short time: of where it was longer ago too little is known.
  long_.past = pairs_.back().past;
  const double seconds = long_.past.seconds;
  const Eigen::Vector3d& velocity = motion->velocity_mps;
  if (motion->gain < kLeastSlowGain || motion->known < kLeastKnown ||
      motion->cost > kMostSlowCost ||
      velocity.dot(motion->covariance.inverse() * velocity) < kLeastSlowWay ||
      velocity.norm() * seconds < params_.min_displacement_m)
    return false;
  const Eigen::Matrix3d R = long_.past.T_past_cam.linear();
  hypothesis.velocity_mps = motion->velocity_mps;
  hypothesis.moved_m = R * motion->velocity_mps * seconds;
  compareLong(input, hypothesis);
  const size_t before = objects.size();
  tryHypothesis(input, long_, hypothesis,
                R * motion->covariance * R.transpose() * seconds * seconds, Source::kSlow, objects);
  return objects.size() > before;
}

// The static world against a frame further back, as far as a hypothesis needs it.
void MotionScheme::compareLong(const DetectionInput& input, const Hypothesis& hypothesis) {
  const cv::Size lattice = frames_[0].pyramid.level(1).size();
  const cv::Rect area = reachOf(input.rig, params_, hypothesis, lattice);
  compareFrames(frames_[0].pyramid, input.measured_disparity_px, range_, long_.past.frame->pyramid,
                SourceOf(disparityMotion(input.rig, long_.past.T_past_cam)), area, compared_);
  long_.static_world.mismatch.create(lattice);
  if (!area.empty()) compared_.mismatch.copyTo(long_.static_world.mismatch(area));
}

void MotionScheme::tryGroup(const DetectionInput& input, const DenseGroup& group,
                            const Baseline& baseline, std::vector<ObservedObject>& objects) {
  const double pixels_per_m = group.disparity_px / input.rig.baseline_m;
  if (static_cast<double>(group.points.size()) * 4 / (pixels_per_m * pixels_per_m) <
      params_.dense_min_area_m2)
    return;
  Hypothesis hypothesis;
  hypothesis.seeds = group.points;
  if (!isFree(hypothesis)) return;
  setLayer(input, hypothesis);
  const auto shift = searchShift(frames_[0].pyramid, baseline.past.frame->pyramid,
                                 SourceOf(disparityMotion(input.rig, baseline.past.T_past_cam)),
                                 input.measured_disparity_px, group.points);
  if (!shift) return;
  const TrackingView view = trackingView(input, baseline.past);
  const std::vector<cv::Point> sample = sampleOf(group.points);
  const std::vector<PointTrack> followed = followPoints(view, params_, sample, shift->shift_px);
  if (static_cast<int>(followed.size()) < params_.min_tracks) return;
  const Displacement fit = fitDisplacement(input.rig, params_, followed, allOf(followed));
  if (static_cast<int>(fit.inliers.size()) < params_.min_tracks ||
      fit.moved_m.norm() < params_.min_displacement_m)
    return;
  hypothesis.moved_m = fit.moved_m;
  if (&baseline == &long_) {
    if (!goesOn(input, sample, shift->shift_px, fit)) return;
    compareLong(input, hypothesis);
  }
  tryHypothesis(input, baseline, hypothesis, fit.covariance, Source::kDense, objects);
}

// An object that is known is looked for where it should be.
void MotionScheme::findKnown(const DetectionInput& input, const ObjectTrack& track,
                             const Baseline& baseline, std::vector<ObservedObject>& objects) {
  const cv::Rect box = track.last.box_px & cv::Rect(cv::Point(), input.rig.size);
  if (box.area() < 100) return;
  Hypothesis hypothesis;
  const double depth = track.last.centre_m.z();
  hypothesis.disparity_px = static_cast<float>(input.rig.disparityTimesDepth() / depth);
  hypothesis.moved_m = baseline.past.frame->T_odom_cam.linear().transpose() *
                       track.state.tail<3>() * baseline.past.seconds;
  if (hypothesis.moved_m.norm() < params_.min_displacement_m) return;
  const float tolerance = 1 + 0.15f * hypothesis.disparity_px;
  for (int v = box.y / 2 + box.height / 8; v < (box.br().y - box.height / 4) / 2; v += 2)
    for (int u = box.x / 2 + box.width / 10; u < (box.br().x - box.width / 5) / 2; u += 2)
      if (std::abs(input.measured_disparity_px(2 * v, 2 * u) - hypothesis.disparity_px) < tolerance)
        hypothesis.seeds.emplace_back(u, v);
  if (hypothesis.seeds.size() < 8) return;
  setLayer(input, hypothesis);
  if (!isFree(hypothesis)) return;
  if (&baseline == &long_) {
    hypothesis.velocity_mps = input.T_odom_cam.linear().transpose() * track.state.tail<3>();
    if (trySlow(input, hypothesis, hypothesis.velocity_mps, objects)) return;
    compareLong(input, hypothesis);
  }
  tryHypothesis(input, baseline, hypothesis, {}, Source::kKnown, objects);
}

void MotionScheme::observe(const DetectionInput& input, const ObjectTracker& known,
                           std::vector<ObservedObject>& objects) {
  remember(input);
  const std::vector<PastFrame> past = pastOf(input);
  if (past.empty()) return;
  const ImagePyramid& current = frames_[0].pyramid;
  const cv::Rect lattice(cv::Point(), current.level(1).size());
  taken_.create(lattice.size());
  taken_.setTo(0);
  if (const auto road = fitRoadLine(input.rig, range_, input.measured_disparity_px)) road_ = road;
  ground_.setFrame(input.rig, range_, input.measured_disparity_px);
  pairs_.clear();
  for (size_t k : kFramesBack)
    if (k <= past.size()) pairs_.push_back({past[k - 1], past[k / 2 - 1]});
  history_.emplace(input.rig, range_, input.measured_disparity_px, past);

  const SourceOf source_of(disparityMotion(input.rig, past[0].T_past_cam));
  short_.past = past[0];
  compareFrames(current, input.measured_disparity_px, range_, past[0].frame->pyramid, source_of,
                lattice, short_.static_world);
  const std::vector<cv::Point>& suspects_px =
      suspicion_.find(current.level(1), short_.static_world.mismatch, input.measured_disparity_px,
                      ground_, params_);
  frames_[0].follows = poseFollows();
  if (!frames_[0].follows) return;
  denseResidual(input, range_, source_of, past[0].frame->disparity_px, lattice.size(),
                short_.residual_px);
  findAcross(input, short_, suspects_px, objects);
  findAlong(input, short_, objects);
  if (!pairs_.empty()) findSlow(input, objects);
  for (const ObjectTrack& track : known.tracks()) {
    if (!track.confirmed) continue;
    const size_t before = objects.size();
    findKnown(input, track, short_, objects);
    if (objects.size() > before || !(track.last.centre_m.z() > 0.5)) continue;
    const int pair = pairWithin(
        input.rig, pairs_, input.rig.disparityFromPoint(track.last.centre_m), kMostParallax_px);
    if (pair < 0) continue;
    long_.past = pairs_[static_cast<size_t>(pair)].past;
    findKnown(input, track, long_, objects);
  }
}

}  // namespace predictive_stereo
