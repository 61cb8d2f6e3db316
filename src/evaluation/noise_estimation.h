/// The paper's section 3: process and measurement noise from LiDAR, and beyond it the parameters of
/// the variance that is published.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "evaluation/error_histogram.h"
#include "evaluation/error_image.h"
#include "evaluation/kitti_drive.h"
#include "evaluation/object_labels.h"
#include "evaluation/sequence.h"
#include "predictive_stereo/pipeline.h"

namespace predictive_stereo {

/// One published disparity with truth, and its observables.
struct VarianceSample {
  float error_px;
  float disparity_px;
  float ambiguity;      ///< 0..1; only where measured
  float innovation_px;  ///< |measured - predicted|; only where both exist
  float disagreements;  ///< see countDisagreements
  float row_offset_px;  ///< of the frame, see RowOffsetModel::rms_offset_px
  bool measured, predicted;
};

/// Samples of one drive. Only static pixels count: where `labels` has movers nothing is used.
struct NoiseObservations {
  ErrorHistogram process;      ///< warped truth of the previous frame minus truth
  ErrorHistogram measurement;  ///< full search without a past minus truth
  ErrorImage process_image, measurement_image;
  std::vector<VarianceSample> published;  ///< of the closed loop
  int frames = 0;
};

/// @param labels  of the drive; empty: nothing is masked.
/// @param max_frames  0: all.
/// @throws std::runtime_error where the drive has no laser scans.
NoiseObservations observeNoise(const KittiDrive& drive, const std::vector<ObjectLabel>& labels,
                               const PipelineParams& params, int max_frames,
                               const std::function<void(int)>& progress);

/// The published disparities of a sequence's closed loop against its truth, every `step`-th pixel
/// of a row and of a column.
std::vector<VarianceSample> observePublished(const Sequence& sequence, const PipelineParams& params,
                                             int step, const std::function<void(int)>& progress);

/// The same of the pairs of a KITTI 2015 "training" folder, each by itself: without a past.
/// @throws std::runtime_error that names what cannot be read.
std::vector<VarianceSample> observePublished2015(const std::string& training_dir,
                                                 const PipelineParams& params, int step,
                                                 const std::function<void(int)>& progress);

/// Errors of laser points of one frame, moved by the ego-motion, against those of the next frame.
/// Points are compared with the plane in disparity space through their neighbours of the next
/// frame, where such a plane fits (smooth surfaces), so that the scans need not hit the same spots.
/// @param points_prev, points  (x, y, disparity) [px] of what the cameras see.
/// @param moving  255 where objects move in the current frame; empty: nowhere.
void addProcessErrors(const std::vector<Eigen::Vector3d>& points_prev,
                      const std::vector<Eigen::Vector3d>& points, const StereoRig& rig,
                      const Eigen::Isometry3d& T_cam_prev, const cv::Mat1b& moving,
                      ErrorHistogram& errors, ErrorImage& image);

/// Parameters of the published variance for which sigma is the 68.3 % and 2 sigma the 95.4 %
/// quantile of the absolute error as nearly as both can be had, given what is known of each pixel:
/// quantile regression, first for what was measured, with and without a prediction, then for what
/// was kept and for what was filled. Each set of samples (a drive, a scene) has the same weight.
/// Kinds with fewer than 200 samples keep the values of `start`, and so does what no sample tells
/// of.
VarianceParams fitVariance(const std::vector<std::vector<VarianceSample>>& sets,
                           const VarianceParams& start);

}  // namespace predictive_stereo
