#pragma once

#include <functional>
#include <string>

#include "tools/kitti_drive.h"

namespace predictive_stereo {

/// Writes a drive with the topics of kitti2bag's `raw_synced` bags:
///
/// - /kitti/camera_{gray,color}_{left,right}/{image_raw,camera_info}: rectified images (mono8 or
///   bgr8) with the name of raw ones; K and D of the unrectified, R and P of the rectified cameras;
///   each camera has its own stamps; frames camera_gray_left, ...
/// - /kitti/oxts/{imu,gps/fix,gps/vel} in frame imu_link and /kitti/velo/pointcloud (x, y, z, i) in
///   frame velo_link, if the drive has them;
/// - /tf world -> base_link if poses are known; /tf_static from base_link to imu_link, from there
///   to velo_link and the cameras, repeated with every frame.
///
/// kitti2bag writes the inertial unit's pose as that of base_link; here it is moved along the lever
/// arm, so that world -> imu_link is exact. In a drive without oxts, base_link is in the left
/// camera's centre (x forward, z up), the poses are those of poses_gt_cam0.txt, and there is no
/// imu_link or velo_link.
///
/// Writes to a temporary file beside `path`, which is renamed at the end, or removed after an
/// error.
/// @param progress  called after each frame with its index; may throw to stop.
/// @throws std::runtime_error with the file that cannot be read or written.
void writeKittiBag(const KittiDrive& drive, const std::string& path,
                   const std::function<void(int)>& progress);

}  // namespace predictive_stereo
