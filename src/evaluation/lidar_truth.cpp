#include "evaluation/lidar_truth.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "evaluation/disparity_metrics.h"

namespace predictive_stereo {

cv::Mat1f lidarTruth(const std::vector<LidarPoint>& points, const Eigen::Isometry3d& T_cam_velo,
                     const StereoRig& rig) {
  constexpr double kMinDepth_m = 1.0;
  constexpr int kColumns = 9, kRows = 5;

  cv::Mat1f nearest_px(rig.size, kNoTruth);
  for (const LidarPoint& point : points) {
    const Eigen::Vector3d point_cam_m = T_cam_velo * Eigen::Vector3d(point.x, point.y, point.z);
    if (!(point_cam_m.z() > kMinDepth_m)) continue;
    const Eigen::Vector3d omega = rig.disparityFromPoint(point_cam_m);
    if (!(omega.x() > -0.5 && omega.x() < rig.size.width - 0.5 && omega.y() > -0.5 &&
          omega.y() < rig.size.height - 0.5))
      continue;
    float& pixel_px = nearest_px(static_cast<int>(std::lround(omega.y())),
                                 static_cast<int>(std::lround(omega.x())));
    pixel_px = std::max(pixel_px, static_cast<float>(omega.z()));
  }

  cv::Mat1f surroundings_px;
  cv::dilate(nearest_px, surroundings_px, cv::Mat1b::ones(2 * kRows + 1, 2 * kColumns + 1));
  cv::Mat1f truth_px = nearest_px.clone();
  for (int y = 0; y < truth_px.rows; ++y)
    for (int x = 0; x < truth_px.cols; ++x)
      if (surroundings_px(y, x) > 1.05f * nearest_px(y, x) + 1.5f) truth_px(y, x) = kNoTruth;
  return truth_px;
}

cv::Mat1f lidarTruth(const KittiDrive& drive, int frame) {
  return lidarTruth(drive.lidar(frame), drive.T_cam_velo(), drive.rig());
}

}  // namespace predictive_stereo
