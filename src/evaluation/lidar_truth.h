#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "tools/kitti_drive.h"

namespace predictive_stereo {

/// The pixel of a point (x, y, disparity).
cv::Point pixelOf(const Eigen::Vector3d& omega);

/// The points of a laser scan that the left camera sees: (x, y, disparity) [px], not rounded.
///
/// These are the points with a depth above 1 m that project into the image; of several points in
/// one pixel the nearest one. The scanner is above the cameras and sees points that are occluded
/// for them: a point with disparity d is dropped if another one within 9 columns and 5 rows has a
/// disparity above 1.05 d + 1.5 px.
std::vector<Eigen::Vector3d> visibleLidarPoints(const std::vector<LidarPoint>& points,
                                                const Eigen::Isometry3d& T_cam_velo,
                                                const StereoRig& rig);

/// Sparse disparity truth [px] of the left image: these points rounded to pixels, kNoTruth
/// elsewhere.
cv::Mat1f lidarTruth(const std::vector<Eigen::Vector3d>& visible_points, cv::Size size);

/// The same for a frame of a drive.
cv::Mat1f lidarTruth(const KittiDrive& drive, int frame);

}  // namespace predictive_stereo
