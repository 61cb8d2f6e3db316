#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "evaluation/kitti_drive.h"

namespace predictive_stereo {

/// What the left camera sees of a laser scan: (x, y, disparity) [px] of its points, exactly.
///
/// Points deeper than 1 m count that project into the image; of several in one pixel the nearest
/// stays. The scanner stands above the cameras and sees past edges: a point is dropped where
/// another one within 9 columns and 5 rows has a disparity above 1.05 d + 1.5 px, because the
/// camera sees that nearer surface.
std::vector<Eigen::Vector3d> visibleLidarPoints(const std::vector<LidarPoint>& points,
                                                const Eigen::Isometry3d& T_cam_velo,
                                                const StereoRig& rig);

/// Sparse disparity truth [px] of the left image: such points rounded to pixels, kNoTruth
/// elsewhere.
cv::Mat1f lidarTruth(const std::vector<Eigen::Vector3d>& visible_points, cv::Size size);

/// The same for a frame of a drive.
cv::Mat1f lidarTruth(const KittiDrive& drive, int frame);

}  // namespace predictive_stereo
