#include "evaluation/lidar_truth.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "evaluation/disparity_metrics.h"

namespace predictive_stereo {

cv::Point pixelOf(const Eigen::Vector3d& omega) {
  return {static_cast<int>(std::lround(omega.x())), static_cast<int>(std::lround(omega.y()))};
}

std::vector<Eigen::Vector3d> visibleLidarPoints(const std::vector<LidarPoint>& points,
                                                const Eigen::Isometry3d& T_cam_velo,
                                                const StereoRig& rig) {
  constexpr double kMinDepth_m = 1.0;
  constexpr int kColumns = 9, kRows = 5;

  std::vector<Eigen::Vector3d> projected;
  cv::Mat1i nearest(rig.size, -1);  // index of the nearest point
  cv::Mat1f nearest_px(rig.size, kNoTruth);
  for (const LidarPoint& point : points) {
    const Eigen::Vector3d point_cam_m = T_cam_velo * Eigen::Vector3d(point.x, point.y, point.z);
    if (!(point_cam_m.z() > kMinDepth_m)) continue;
    const Eigen::Vector3d omega = rig.disparityFromPoint(point_cam_m);
    if (!(omega.x() > -0.5 && omega.x() < rig.size.width - 0.5 && omega.y() > -0.5 &&
          omega.y() < rig.size.height - 0.5))
      continue;
    const cv::Point pixel = pixelOf(omega);
    if (omega.z() > nearest_px(pixel)) {
      nearest_px(pixel) = static_cast<float>(omega.z());
      nearest(pixel) = static_cast<int>(projected.size());
    }
    projected.push_back(omega);
  }

  cv::Mat1f surroundings_px;
  cv::dilate(nearest_px, surroundings_px, cv::Mat1b::ones(2 * kRows + 1, 2 * kColumns + 1));
  std::vector<Eigen::Vector3d> visible;
  for (int y = 0; y < nearest.rows; ++y)
    for (int x = 0; x < nearest.cols; ++x)
      if (nearest(y, x) >= 0 && surroundings_px(y, x) <= 1.05f * nearest_px(y, x) + 1.5f)
        visible.push_back(projected[static_cast<size_t>(nearest(y, x))]);
  return visible;
}

cv::Mat1f lidarTruth(const std::vector<Eigen::Vector3d>& visible_points, cv::Size size) {
  cv::Mat1f truth_px(size, kNoTruth);
  for (const Eigen::Vector3d& omega : visible_points)
    truth_px(pixelOf(omega)) = static_cast<float>(omega.z());
  return truth_px;
}

cv::Mat1f lidarTruth(const KittiDrive& drive, int frame) {
  return lidarTruth(visibleLidarPoints(drive.lidar(frame), drive.T_cam_velo(), drive.rig()),
                    drive.rig().size);
}

}  // namespace predictive_stereo
