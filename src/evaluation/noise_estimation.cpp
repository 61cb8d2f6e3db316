#include "evaluation/noise_estimation.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "evaluation/disparity_metrics.h"
#include "evaluation/lidar_truth.h"
#include "evaluation/report.h"
#include "tools/progress.h"

namespace predictive_stereo {
namespace {

constexpr int kMoverMarginPx = 6;

/// Points, indexed by the pixel that they are rounded to.
class PointGrid {
 public:
  PointGrid(const std::vector<Eigen::Vector3d>& points, cv::Size size)
      : index_(size, -1), points_(points) {
    for (size_t i = 0; i < points.size(); ++i) index_(pixelOf(points[i])) = static_cast<int>(i);
  }

  /// Disparity at (x, y) of the plane through the points around it. None if these are not on one
  /// plane, or not on all sides.
  std::optional<double> planeAt(const Eigen::Vector3d& omega) const {
    constexpr int kColumns = 8, kRows = 6, kMinPoints = 8;
    constexpr double kMaxRms_px = 0.25;
    const cv::Point centre = pixelOf(omega);
    if (!cv::Rect(kColumns, kRows, index_.cols - 2 * kColumns, index_.rows - 2 * kRows)
             .contains(centre))
      return std::nullopt;
    Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    double squares = 0;
    int count = 0, sides = 0;
    for (int y = centre.y - kRows; y <= centre.y + kRows; ++y)
      for (int x = centre.x - kColumns; x <= centre.x + kColumns; ++x) {
        if (index_(y, x) < 0) continue;
        const Eigen::Vector3d& point = points_[static_cast<size_t>(index_(y, x))];
        const Eigen::Vector3d row(1, point.x() - omega.x(), point.y() - omega.y());
        A += row * row.transpose();
        b += row * point.z();
        squares += point.z() * point.z();
        sides |= 1 << ((row.y() > 0 ? 1 : 0) + (row.z() > 0 ? 2 : 0));
        ++count;
      }
    if (count < kMinPoints || sides != 15) return std::nullopt;
    const Eigen::LDLT<Eigen::Matrix3d> ldlt(A);
    if (ldlt.rcond() < 1e-6) return std::nullopt;
    const Eigen::Vector3d plane = ldlt.solve(b);
    const double residual = std::max(0.0, squares - b.dot(plane));
    if (residual > kMaxRms_px * kMaxRms_px * count) return std::nullopt;
    return plane[0];
  }

 private:
  cv::Mat1i index_;
  const std::vector<Eigen::Vector3d>& points_;
};

std::optional<CameraMotion> unknownMotion(const Past&) { return {}; }

}  // namespace

void ErrorHistogram::add(double error_px) {
  all_.add(error_px);
  if (!(std::abs(error_px) < kLimit_px)) return;
  const int step = static_cast<int>((error_px + kLimit_px) / kStep_px);
  ++steps_[static_cast<size_t>(std::clamp(step, 0, kSteps - 1))];
  inside_.add(error_px);
}

ErrorHistogram& ErrorHistogram::operator+=(const ErrorHistogram& other) {
  for (size_t i = 0; i < steps_.size(); ++i) steps_[i] += other.steps_[i];
  inside_ += other.inside_;
  all_ += other.all_;
  return *this;
}

double ErrorHistogram::quantile_px(double share) const {
  const double wanted = share * static_cast<double>(inside_.count());
  double below = 0;
  for (int i = 0; i < kSteps; ++i) {
    const auto inside = static_cast<double>(steps_[static_cast<size_t>(i)]);
    if (below + inside >= wanted && inside > 0)
      return -kLimit_px + kStep_px * (i + (wanted - below) / inside);
    below += inside;
  }
  return kLimit_px;
}

double ErrorHistogram::robustSigma_px() const {
  return (quantile_px(0.8413) - quantile_px(0.1587)) / 2;
}

double ErrorHistogram::shareWithin(double limit_px) const {
  int64_t within = 0;
  for (int i = 0; i < kSteps; ++i)
    if (std::abs(-kLimit_px + kStep_px * (i + 0.5)) < limit_px)
      within += steps_[static_cast<size_t>(i)];
  return ratio(within, count());
}

std::string ErrorHistogram::csv() const {
  Table csv = Table::ofCsv("error_px,count,share");
  for (int i = 0; i < kSteps; ++i) {
    const int64_t step = steps_[static_cast<size_t>(i)];
    csv.add(-kLimit_px + kStep_px * (i + 0.5), step, ratio(step, count()));
  }
  return csv.csv();
}

ErrorImage::ErrorImage(cv::Size size)
    : size_(size),
      sums_px_((size.height + kCell_px - 1) / kCell_px, (size.width + kCell_px - 1) / kCell_px,
               0.0) {}

void ErrorImage::add(double x_px, double y_px, double error_px) {
  const cv::Point pixel = pixelOf({x_px, y_px, 0});
  if (cv::Rect(cv::Point(), size_).contains(pixel))
    sums_px_(pixel / kCell_px) += std::abs(error_px);
}

cv::Mat1w ErrorImage::map() const {
  double most_px = 0;
  cv::minMaxLoc(sums_px_, nullptr, &most_px);
  cv::Mat1w levels;
  sums_px_.convertTo(levels, CV_16U, most_px > 0 ? 65535 / most_px : 0);
  cv::resize(levels, levels, {}, kCell_px, kCell_px, cv::INTER_NEAREST);
  return levels(cv::Rect({}, size_)).clone();
}

void addProcessErrors(const std::vector<Eigen::Vector3d>& points_prev,
                      const std::vector<Eigen::Vector3d>& points, const StereoRig& rig,
                      const Eigen::Isometry3d& T_cam_prev, const cv::Mat1b& moving,
                      ErrorHistogram& errors, ErrorImage& image) {
  const PointGrid grid(points, rig.size);
  const Eigen::Matrix4d H = disparityMotion(rig, T_cam_prev);
  for (const Eigen::Vector3d& point : points_prev) {
    const Eigen::Vector3d moved = (H * point.homogeneous()).hnormalized();
    const cv::Point pixel = pixelOf(moved);
    if (!cv::Rect({}, rig.size).contains(pixel) || (!moving.empty() && moving(pixel))) continue;
    const auto truth_px = grid.planeAt(moved);
    if (!truth_px) continue;
    errors.add(moved.z() - *truth_px);
    image.add(moved.x(), moved.y(), moved.z() - *truth_px);
  }
}

NoiseObservations observeNoise(const KittiDrive& drive, const std::vector<ObjectLabel>& labels,
                               const PipelineParams& params, int max_frames) {
  NoiseObservations seen(drive.rig().size);
  const DisparityRange range = params.disparity.matcher.range;
  DisparityParams full = params.disparity;
  full.search.scheme = SearchScheme::kFull;
  DisparityLoop each_by_itself(full, params.max_gap);
  Pipeline closed_loop(params);
  DisparityOutput measured;
  PipelineOutput output;
  const std::vector<int64_t> stamps_ns = drive.stamps(KittiDrive::imageFolder(drive.leftCamera()));
  std::vector<Eigen::Vector3d> points_prev;
  std::optional<Stamp> stamp_prev;
  const int frames = max_frames > 0 ? std::min(max_frames, drive.frames()) : drive.frames();
  Progress progress(drive.name(), frames);
  for (int index = 0; index < frames; ++index) {
    const StereoFrame frame{drive.left(index), drive.right(index), drive.rig(),
                            Stamp(stamps_ns.at(static_cast<size_t>(index)))};
    closed_loop.process(frame, output);

    std::vector<Eigen::Vector3d> points;
    if (drive.hasLidar(index)) {
      const cv::Mat1b moving =
          movingMask(labels, drive.fileNumber(index), drive.rig().size, kMoverMarginPx);
      points = visibleLidarPoints(drive.lidar(index), drive.T_cam_velo(), drive.rig());
      cv::Mat1f truth_px = lidarTruth(points, drive.rig().size);
      truth_px.setTo(kNoTruth, moving);
      each_by_itself.process(frame, unknownMotion, measured);
      forEachError(measured.measured_disparity_px, range, truth_px,
                   [&](int x, int y, double error_px) {
                     seen.measurement.add(error_px);
                     seen.measurement_image.add(x, y, error_px);
                   });
      if (!points_prev.empty() && output.motion_start == stamp_prev)
        addProcessErrors(points_prev, points, drive.rig(), output.ego_motion.motion.T_cam_prev,
                         moving, seen.process, seen.process_image);
      ++seen.frames;
    }
    points_prev = std::move(points);
    stamp_prev = frame.stamp;
    progress.update(index);
  }
  if (seen.frames == 0)
    throw std::runtime_error(drive.name() +
                             ": has no laser scans (velodyne_points); choose another drive");
  return seen;
}

}  // namespace predictive_stereo
