#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

/// A pair of the KITTI 2015 scene flow benchmark (training) with its disparity truth.
struct KittiScene2015 {
  std::string name;  ///< six digits, e.g. "000002"
  StereoRig rig;
  cv::Mat1b left, right;
  cv::Mat1f truth_px;      ///< disp_occ_0; kNoTruth where there is none
  cv::Mat1f truth_noc_px;  ///< disp_noc_0, without occluded pixels; empty where the folder lacks it
  cv::Mat1b vehicles;      ///< 255 on vehicles that move (obj_map > 0)
};

/// The scenes of a folder that have truth, sorted.
/// @param training_dir  the folder with image_2, image_3, disp_occ_0, obj_map, calib_cam_to_cam.
/// @throws std::runtime_error that names the folder where there are none.
std::vector<std::string> listKittiScenes2015(const std::string& training_dir);

/// @throws std::runtime_error that names the file which cannot be read, or is of another size.
KittiScene2015 readKittiScene2015(const std::string& training_dir, const std::string& scene);

}  // namespace predictive_stereo
