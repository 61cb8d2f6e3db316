#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "evaluation/kitti_drive.h"

namespace predictive_stereo {

/// Sparse disparity truth [px] in the left image from one laser scan; kNoTruth elsewhere.
///
/// Points deeper than 1 m are projected and rounded to a pixel; the nearest of several in one pixel
/// stays. The scanner stands above the cameras and sees past edges: a point is dropped where
/// another one within 9 columns and 5 rows has a disparity above 1.05 d + 1.5 px, because the
/// camera sees that nearer surface.
cv::Mat1f lidarTruth(const std::vector<LidarPoint>& points, const Eigen::Isometry3d& T_cam_velo,
                     const StereoRig& rig);

/// The same for a frame of a drive.
cv::Mat1f lidarTruth(const KittiDrive& drive, int frame);

}  // namespace predictive_stereo
