/// The paper's section 3: process and measurement noise from LiDAR.
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "evaluation/object_labels.h"
#include "evaluation/statistics.h"
#include "predictive_stereo/pipeline.h"
#include "tools/kitti_drive.h"

namespace predictive_stereo {

/// Distribution of disparity errors [px] in steps of 0.02 px from -3 to 3. Errors outside are gross
/// errors: they are counted, but are not noise (the paper does not distinguish them).
class ErrorHistogram {
 public:
  static constexpr double kLimit_px = 3.0;
  static constexpr double kStep_px = 0.02;

  void add(double error_px);
  ErrorHistogram& operator+=(const ErrorHistogram& other);

  int64_t count() const { return all_.count(); }
  double grossShare() const { return ratio(count() - inside_.count(), count()); }
  /// Of the errors that are not gross.
  double mean_px() const { return inside_.mean(); }
  double variance_px2() const { return inside_.variance(); }
  /// Of all errors, gross ones included.
  double varianceOfAll_px2() const { return all_.variance(); }
  /// Half the width of the interval with the middle 68.3 %: sigma of a normal distribution.
  double robustSigma_px() const;
  double shareWithin(double limit_px) const;

  /// Lines "error_px,count,share", with the middle of each step as error.
  std::string csv() const;

 private:
  static constexpr int kSteps = 300;
  /// Quantile of the errors that are not gross.
  double quantile_px(double share) const;

  std::array<int64_t, kSteps> steps_{};
  Moments inside_, all_;
};

/// Distribution of errors over the image: accumulated absolute errors (the paper's figure 3).
class ErrorImage {
 public:
  static constexpr int kCell_px = 4;  ///< rows and columns of a cell; laser points are sparse

  explicit ErrorImage(cv::Size size);

  void add(double x_px, double y_px, double error_px);
  /// Sum of absolute errors [px] of the cell that contains this pixel.
  double sum_px(int x_px, int y_px) const { return sums_px_(y_px / kCell_px, x_px / kCell_px); }

  /// The sums, relative to the largest one, which is 65535, for every pixel of the image.
  cv::Mat1w map() const;

 private:
  cv::Size size_;
  cv::Mat1d sums_px_;  ///< one per cell
};

/// Errors of one drive, without the moving objects in `labels`.
struct NoiseObservations {
  explicit NoiseObservations(cv::Size size) : process_image(size), measurement_image(size) {}

  ErrorHistogram process;      ///< warped truth of the previous frame minus truth
  ErrorHistogram measurement;  ///< full search without a past minus truth
  ErrorImage process_image, measurement_image;
  int frames = 0;
};

/// @param labels  of the drive; empty: nothing is masked.
/// @param max_frames  0: all.
/// @throws std::runtime_error if the drive has no laser scans.
NoiseObservations observeNoise(const KittiDrive& drive, const std::vector<ObjectLabel>& labels,
                               const PipelineParams& params, int max_frames);

/// Errors of laser points of one frame, moved by the ego-motion, against those of the next frame. A
/// point is compared with the plane in disparity space through its neighbours in the next frame, if
/// a plane fits (smooth surfaces): the scans do not hit the same points.
/// @param points_prev, points  (x, y, disparity) [px] of visible points, see visibleLidarPoints.
/// @param moving  255 on moving objects of the current frame; empty: none.
void addProcessErrors(const std::vector<Eigen::Vector3d>& points_prev,
                      const std::vector<Eigen::Vector3d>& points, const StereoRig& rig,
                      const Eigen::Isometry3d& T_cam_prev, const cv::Mat1b& moving,
                      ErrorHistogram& errors, ErrorImage& image);

}  // namespace predictive_stereo
