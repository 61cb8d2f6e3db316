#include "evaluation/noise_estimation.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core/optim.hpp>
#include <random>
#include <stdexcept>

#include "evaluation/disparity_metrics.h"
#include "evaluation/kitti_scene_2015.h"
#include "evaluation/lidar_truth.h"

namespace predictive_stereo {
namespace {

constexpr int kMoverMarginPx = 6;
constexpr double kOneSigma = 0.6827, kTwoSigma = 0.9545;
constexpr size_t kMinSamples = 200;

/// Points, indexed by the pixel that they are rounded to.
class PointGrid {
 public:
  PointGrid(const std::vector<Eigen::Vector3d>& points, cv::Size size)
      : index_(size, -1), points_(points) {
    for (size_t i = 0; i < points.size(); ++i)
      index_(static_cast<int>(std::lround(points[i].y())),
             static_cast<int>(std::lround(points[i].x()))) = static_cast<int>(i);
  }

  /// Disparity at (x, y) of the plane through the points around it. False if these are not on one
  /// plane, or not on all sides.
  bool planeAt(double x_px, double y_px, double& disparity_px) const {
    constexpr int kColumns = 8, kRows = 6, kMinPoints = 8;
    constexpr double kMaxRms_px = 0.25;
    const int cx = static_cast<int>(std::lround(x_px)), cy = static_cast<int>(std::lround(y_px));
    if (cx < kColumns || cy < kRows || cx >= index_.cols - kColumns || cy >= index_.rows - kRows)
      return false;
    Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    double squares = 0;
    int count = 0, sides = 0;
    for (int y = cy - kRows; y <= cy + kRows; ++y)
      for (int x = cx - kColumns; x <= cx + kColumns; ++x) {
        if (index_(y, x) < 0) continue;
        const Eigen::Vector3d& point = points_[static_cast<size_t>(index_(y, x))];
        const Eigen::Vector3d row(1, point.x() - x_px, point.y() - y_px);
        A += row * row.transpose();
        b += row * point.z();
        squares += point.z() * point.z();
        sides |= 1 << ((row.y() > 0 ? 1 : 0) + (row.z() > 0 ? 2 : 0));
        ++count;
      }
    if (count < kMinPoints || sides != 15) return false;
    const Eigen::LDLT<Eigen::Matrix3d> ldlt(A);
    if (ldlt.rcond() < 1e-6) return false;
    const Eigen::Vector3d plane = ldlt.solve(b);
    const double residual = std::max(0.0, squares - b.dot(plane));
    if (residual > kMaxRms_px * kMaxRms_px * count) return false;
    disparity_px = plane[0];
    return true;
  }

 private:
  cv::Mat1i index_;
  const std::vector<Eigen::Vector3d>& points_;
};

void addMeasurementErrors(const cv::Mat1f& measured_px, const DisparityRange& range,
                          const cv::Mat1f& truth_px, ErrorHistogram& errors, ErrorImage& image) {
  for (int y = 0; y < truth_px.rows; ++y)
    for (int x = 0; x < truth_px.cols; ++x) {
      if (!hasTruth(truth_px(y, x)) || !range.isValid(measured_px(y, x))) continue;
      const double error_px = static_cast<double>(measured_px(y, x)) - truth_px(y, x);
      errors.add(error_px);
      image.add(x, y, error_px);
    }
}

void addSamples(const DisparityOutput& maps, const DisparityRange& range, const cv::Mat1f& truth_px,
                int step, std::vector<VarianceSample>& samples) {
  cv::Mat1f disagreements;
  measureDisagreement(maps.disparity_px, range, disagreements);
  for (int y = 0; y < truth_px.rows; y += step)
    for (int x = 0; x < truth_px.cols; x += step) {
      if (!hasTruth(truth_px(y, x)) || !range.isValid(maps.disparity_px(y, x))) continue;
      VarianceSample sample;
      sample.error_px = maps.disparity_px(y, x) - truth_px(y, x);
      sample.disparity_px = maps.disparity_px(y, x);
      sample.measured = range.isValid(maps.measured_disparity_px(y, x));
      sample.predicted = range.isValid(maps.predicted_disparity_px(y, x));
      sample.ambiguity = static_cast<float>(maps.ambiguity(y, x)) / 255.0f;
      sample.innovation_px =
          std::abs(maps.measured_disparity_px(y, x) - maps.predicted_disparity_px(y, x));
      sample.disagreement = disagreements(y, x);
      sample.row_offset_px = static_cast<float>(maps.row_alignment.rms_offset_px);
      samples.push_back(sample);
    }
}

double matchSigma(const VarianceSample& sample, const VarianceParams& params) {
  const double t =
      std::max(0.0, (sample.ambiguity - params.ambiguity_onset) / (1.0 - params.ambiguity_onset));
  return params.sigma_floor_px + params.sigma_ambiguous_px * t * t;
}

/// The part of the variance that is the same for measured, kept and filled disparities.
double commonVariance(const VarianceSample& sample, const VarianceParams& params) {
  const double ambiguity = sample.measured ? sample.ambiguity : 1;
  const double doubt = 1 + params.ambiguity_weight * ambiguity * ambiguity +
                       (sample.measured && !sample.predicted ? params.unpredicted_weight : 0);
  const double around_px = params.sigma_disagreement_px * sample.disagreement * doubt;
  const double far_px = rectificationShare(sample.row_offset_px) * params.sigma_far_px /
                        (1 + std::max(sample.disparity_px, 0.0f) / kFarDisparityPx);
  const double rig_px = params.sigma_per_row_offset * sample.row_offset_px * sample.disparity_px;
  return around_px * around_px + far_px * far_px + rig_px * rig_px;
}

/// The part of a match's variance that depends on the prediction, or its absence.
double innovationVariance(const VarianceSample& sample, const VarianceParams& params) {
  if (!sample.predicted) {
    const double unpredicted_px =
        rectificationShare(sample.row_offset_px) * params.sigma_unpredicted_px;
    return unpredicted_px * unpredicted_px;
  }
  const double innovation_px = std::min<double>(sample.innovation_px, params.max_innovation_px);
  return params.innovation_weight * innovation_px * innovation_px;
}

/// Loss of quantile regression for sigma as the 68.3 % and 2 sigma as the 95.4 % quantile of
/// |error|. It uses logarithms, which have the same quantiles: all pixels then have the same
/// weight, as for the shares of errors within 1 and 2 sigma. Without logarithms large errors would
/// dominate.
double quantileLoss(double error_px, double sigma_px) {
  constexpr double kFinestError_px = 0.01;
  const double beyond = std::log(std::max(std::abs(error_px), kFinestError_px) / sigma_px);
  const auto loss = [](double log_ratio, double share) {
    return log_ratio > 0 ? share * log_ratio : (share - 1) * log_ratio;
  };
  return loss(beyond, kOneSigma) + loss(beyond - std::log(2.0), kTwoSigma);
}

/// An error and the known part of its variance.
struct KnownPart {
  double error_px, variance_px2;
};

/// The s for which sigma = sqrt(known variance + s^2) has the smallest loss.
double addedSigma(const std::vector<KnownPart>& samples, double otherwise) {
  if (samples.size() < kMinSamples) return otherwise;
  double best = otherwise, least = std::numeric_limits<double>::infinity();
  for (double s = 0.01; s < 10; s *= 1.04) {
    double loss = 0;
    for (const KnownPart& sample : samples)
      loss += quantileLoss(sample.error_px, std::sqrt(sample.variance_px2 + s * s));
    if (loss < least) {
      least = loss;
      best = s;
    }
  }
  return best;
}

/// A random choice of samples for which `keep` holds: the same number from each set, at most
/// `count`.
std::vector<VarianceSample> chooseSamples(const std::vector<std::vector<VarianceSample>>& sets,
                                          size_t count, bool (*keep)(const VarianceSample&)) {
  std::vector<std::vector<VarianceSample>> kept(sets.size());
  for (size_t i = 0; i < sets.size(); ++i) {
    std::copy_if(sets[i].begin(), sets[i].end(), std::back_inserter(kept[i]), keep);
    if (!kept[i].empty()) count = std::min(count, kept[i].size());
  }
  std::vector<VarianceSample> chosen;
  std::mt19937 random(1);
  for (auto& samples : kept) {
    if (samples.empty()) continue;
    // Not std::shuffle: its result depends on the standard library.
    for (size_t i = 0; i < count; ++i) {
      std::swap(samples[i], samples[i + random() % (samples.size() - i)]);
      chosen.push_back(samples[i]);
    }
  }
  return chosen;
}

/// Mean loss as a function of floor, ambiguous, onset, innovation_weight, disagreement,
/// per_row_offset (times 100), far, unpredicted, ambiguity_weight, unpredicted_weight.
class MatchLoss : public cv::MinProblemSolver::Function {
 public:
  MatchLoss(std::vector<VarianceSample> samples, const VarianceParams& start)
      : samples_(std::move(samples)), start_(start) {}
  int getDims() const override { return 10; }
  double calc(const double* x) const override {
    // The solver has no bounds: the loss grows outside the limits.
    double penalty = 0;
    const auto limited = [&penalty](double value, double low, double high) {
      const double inside = std::clamp(value, low, high);
      penalty += std::abs(value - inside);
      return inside;
    };
    VarianceParams params = start_;
    params.sigma_floor_px = limited(x[0], 0.05, 10);
    params.sigma_ambiguous_px = limited(x[1], 0, 100);
    params.ambiguity_onset = limited(x[2], 0, 0.9);
    params.innovation_weight = limited(x[3], 0, 1);
    params.sigma_disagreement_px = limited(x[4], 0, 100);
    params.sigma_per_row_offset = limited(x[5], 0, 100) / 100;
    params.sigma_far_px = limited(x[6], 0, 100);
    params.sigma_unpredicted_px = limited(x[7], 0, 100);
    params.ambiguity_weight = limited(x[8], 0, 100);
    params.unpredicted_weight = limited(x[9], 0, 100);
    double loss = 0;
    for (const VarianceSample& sample : samples_) {
      const double match_px = matchSigma(sample, params);
      loss += quantileLoss(sample.error_px,
                           std::sqrt(match_px * match_px + innovationVariance(sample, params) +
                                     commonVariance(sample, params)));
    }
    return loss / static_cast<double>(samples_.size()) + penalty;
  }

 private:
  std::vector<VarianceSample> samples_;
  VarianceParams start_;
};

bool isMeasured(const VarianceSample& s) { return s.measured; }
bool isPredicted(const VarianceSample& s) { return s.predicted; }
bool isKept(const VarianceSample& s) { return !s.measured && s.predicted; }
bool isFilled(const VarianceSample& s) { return !s.measured && !s.predicted; }

PipelineParams withAllPublished(PipelineParams params) {
  params.disparity.variance.max_sigma_px = 0;
  return params;
}

std::optional<CameraMotion> unknownMotion(const Past&) { return {}; }

double rounded(double value) {
  if (value < 1e-6) return 0;
  const double unit = std::pow(10, std::floor(std::log10(value)) - 1);
  return std::round(value / unit) * unit;
}

}  // namespace

void addProcessErrors(const std::vector<Eigen::Vector3d>& points_prev,
                      const std::vector<Eigen::Vector3d>& points, const StereoRig& rig,
                      const Eigen::Isometry3d& T_cam_prev, const cv::Mat1b& moving,
                      ErrorHistogram& errors, ErrorImage& image) {
  const PointGrid grid(points, rig.size);
  const Eigen::Matrix4d H = disparityMotion(rig, T_cam_prev);
  for (const Eigen::Vector3d& point : points_prev) {
    const Eigen::Vector3d moved = (H * point.homogeneous()).hnormalized();
    const int x = static_cast<int>(std::lround(moved.x())),
              y = static_cast<int>(std::lround(moved.y()));
    if (x < 0 || y < 0 || x >= rig.size.width || y >= rig.size.height) continue;
    if (!moving.empty() && moving(y, x)) continue;
    double truth_px = 0;
    if (!grid.planeAt(moved.x(), moved.y(), truth_px)) continue;
    errors.add(moved.z() - truth_px);
    image.add(moved.x(), moved.y(), moved.z() - truth_px);
  }
}

NoiseObservations observeNoise(const KittiDrive& drive, const std::vector<ObjectLabel>& labels,
                               const PipelineParams& params, int max_frames,
                               const std::function<void(int)>& progress) {
  NoiseObservations seen;
  seen.process_image = ErrorImage(drive.rig().size);
  seen.measurement_image = ErrorImage(drive.rig().size);
  const DisparityRange range = params.disparity.matcher.range;
  DisparityParams full = params.disparity;
  full.search.scheme = SearchScheme::kFull;
  DisparityLoop each_by_itself(full, params.max_gap);
  Pipeline closed_loop(withAllPublished(params));
  DisparityOutput measured;
  PipelineOutput published;
  const std::vector<int64_t> stamps_ns = drive.stamps(KittiDrive::imageFolder(drive.leftCamera()));
  std::vector<Eigen::Vector3d> points_prev;
  std::optional<Stamp> stamp_prev;
  const int frames = max_frames > 0 ? std::min(max_frames, drive.frames()) : drive.frames();
  for (int index = 0; index < frames; ++index) {
    const StereoFrame frame{drive.left(index), drive.right(index), drive.rig(),
                            Stamp(stamps_ns.at(static_cast<size_t>(index)))};
    closed_loop.process(frame, published);

    std::vector<Eigen::Vector3d> points;
    if (drive.hasLidar(index)) {
      const cv::Mat1b moving =
          movingMask(labels, drive.fileNumber(index), drive.rig().size, kMoverMarginPx);
      points = visibleLidarPoints(drive.lidar(index), drive.T_cam_velo(), drive.rig());
      cv::Mat1f truth_px = lidarTruth(points, drive.rig().size);
      truth_px.setTo(kNoTruth, moving);
      each_by_itself.process(frame, unknownMotion, measured);
      addMeasurementErrors(measured.measured_disparity_px, range, truth_px, seen.measurement,
                           seen.measurement_image);
      if (index > 0) addSamples(published.disparity, range, truth_px, 1, seen.published);
      if (!points_prev.empty() && published.motion_start == stamp_prev)
        addProcessErrors(points_prev, points, drive.rig(), published.ego_motion.motion.T_cam_prev,
                         moving, seen.process, seen.process_image);
      ++seen.frames;
    }
    points_prev = std::move(points);
    stamp_prev = frame.stamp;
    if (progress) progress(index);
  }
  if (seen.frames == 0)
    throw std::runtime_error(drive.name() +
                             ": has no laser scans (velodyne_points); choose another drive");
  return seen;
}

std::vector<VarianceSample> observePublished(const Sequence& sequence, const PipelineParams& params,
                                             int step, const std::function<void(int)>& progress) {
  std::vector<VarianceSample> samples;
  Pipeline closed_loop(withAllPublished(params));
  PipelineOutput published;
  for (int index = 0; index < sequence.frames(); ++index) {
    const SequenceFrame frame = sequence.frame(index);
    closed_loop.process(stereoFrame(sequence, index, frame), published);
    if (index > 0 && !frame.truth_px.empty())
      addSamples(published.disparity, params.disparity.matcher.range, frame.truth_px, step,
                 samples);
    if (progress) progress(index);
  }
  return samples;
}

std::vector<VarianceSample> observePublished2015(const std::string& training_dir,
                                                 const PipelineParams& params, int step,
                                                 const std::function<void(int)>& progress) {
  std::vector<VarianceSample> samples;
  const PipelineParams all = withAllPublished(params);
  int pair = 0;
  for (const std::string& name : listKittiScenes2015(training_dir)) {
    const KittiScene2015 scene = readKittiScene2015(training_dir, name);
    DisparityLoop loop(all.disparity, all.max_gap);
    DisparityOutput published;
    loop.process({scene.left, scene.right, scene.rig, {}}, unknownMotion, published);
    addSamples(published, params.disparity.matcher.range, scene.truth_px, step, samples);
    if (progress) progress(pair++);
  }
  return samples;
}

VarianceParams fitVariance(const std::vector<std::vector<VarianceSample>>& sets,
                           const VarianceParams& start) {
  constexpr size_t kSamples = 60000;
  VarianceParams fitted = start;
  std::vector<VarianceSample> measured = chooseSamples(sets, kSamples, isMeasured);
  if (measured.size() >= kMinSamples) {
    const auto with_past =
        static_cast<size_t>(std::count_if(measured.begin(), measured.end(), isPredicted));
    const size_t without_past = measured.size() - with_past;
    const auto loss = cv::makePtr<MatchLoss>(std::move(measured), start);
    cv::Mat1d x = (cv::Mat1d(1, 10) << start.sigma_floor_px, start.sigma_ambiguous_px,
                   start.ambiguity_onset, start.innovation_weight, start.sigma_disagreement_px,
                   100 * start.sigma_per_row_offset, start.sigma_far_px, start.sigma_unpredicted_px,
                   start.ambiguity_weight, start.unpredicted_weight);
    const auto solver = cv::DownhillSolver::create(
        loss, cv::Mat1d((cv::Mat1d(1, 10) << 0.1, 0.3, 0.1, 0.1, 0.2, 0.5, 0.2, 0.2, 1.0, 0.5)),
        cv::TermCriteria(cv::TermCriteria::MAX_ITER + cv::TermCriteria::EPS, 1200, 1e-7));
    solver->minimize(x);
    fitted.sigma_floor_px = rounded(std::clamp(x(0), 0.05, 10.0));
    fitted.sigma_ambiguous_px = rounded(std::clamp(x(1), 0.0, 100.0));
    fitted.ambiguity_onset = rounded(std::clamp(x(2), 0.0, 0.9));
    if (with_past >= kMinSamples) fitted.innovation_weight = rounded(std::clamp(x(3), 0.0, 1.0));
    fitted.sigma_disagreement_px = rounded(std::clamp(x(4), 0.0, 100.0));
    fitted.sigma_per_row_offset = rounded(std::clamp(x(5), 0.0, 100.0) / 100);
    fitted.sigma_far_px = rounded(std::clamp(x(6), 0.0, 100.0));
    if (without_past >= kMinSamples)
      fitted.sigma_unpredicted_px = rounded(std::clamp(x(7), 0.0, 100.0));
    fitted.ambiguity_weight = rounded(std::clamp(x(8), 0.0, 100.0));
    if (with_past >= kMinSamples && without_past >= kMinSamples)
      fitted.unpredicted_weight = rounded(std::clamp(x(9), 0.0, 100.0));
  }
  const auto beyondCommon = [&](bool (*kind)(const VarianceSample&)) {
    std::vector<KnownPart> parts;
    for (const VarianceSample& sample : chooseSamples(sets, kSamples, kind))
      parts.push_back({sample.error_px, commonVariance(sample, fitted)});
    return parts;
  };
  fitted.sigma_kept_px = rounded(addedSigma(beyondCommon(isKept), start.sigma_kept_px));
  fitted.sigma_filled_px = rounded(addedSigma(beyondCommon(isFilled), start.sigma_filled_px));
  return fitted;
}

}  // namespace predictive_stereo
