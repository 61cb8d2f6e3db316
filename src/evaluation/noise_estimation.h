/// The paper's section 3: process and measurement noise from LiDAR.
#pragma once

#include <string>
#include <vector>

#include "evaluation/error_distribution.h"
#include "evaluation/object_labels.h"
#include "evaluation/sequence.h"
#include "evaluation/variance_fit.h"
#include "predictive_stereo/pipeline.h"
#include "tools/kitti_drive.h"

namespace predictive_stereo {

/// Samples of one drive, without the moving objects in `labels`.
struct NoiseObservations {
  ErrorHistogram process;      ///< warped truth of the previous frame minus truth
  ErrorHistogram measurement;  ///< full search without a past minus truth
  ErrorImage process_image, measurement_image;
  std::vector<VarianceSample> published;  ///< of the whole pipeline in closed loop
  int frames = 0;
};

/// @param labels  of the drive; empty: nothing is masked.
/// @param max_frames  0: all.
/// @throws std::runtime_error if the drive has no laser scans.
NoiseObservations observeNoise(const KittiDrive& drive, const std::vector<ObjectLabel>& labels,
                               const PipelineParams& params, int max_frames);

/// The published disparities of a sequence, in closed loop, against its truth: every `step`-th
/// pixel of a row and of a column.
std::vector<VarianceSample> observePublished(const Sequence& sequence, const PipelineParams& params,
                                             int step);

/// The same for the pairs of a KITTI 2015 "training" folder, each without a past.
/// @throws std::runtime_error with the file that cannot be read.
std::vector<VarianceSample> observePublished2015(const std::string& training_dir,
                                                 const PipelineParams& params, int step);

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
