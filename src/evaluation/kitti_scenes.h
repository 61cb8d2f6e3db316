/// Training scenes of KITTI's stereo benchmarks. Those of 2012 are sequences, see
/// kittiScene2012Sequence.
///
/// Every failure is a std::runtime_error with the name of the file or folder.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

/// The scenes with truth, six digits each, sorted; at least one.
/// @param training_dir  the folder with image_0, image_1, calib and disp_occ.
std::vector<std::string> listKittiScenes2012(const std::string& training_dir);
/// @param training_dir  the folder with image_2, image_3, disp_occ_0, obj_map, calib_cam_to_cam.
std::vector<std::string> listKittiScenes2015(const std::string& training_dir);

/// A pair of the KITTI 2015 scene flow benchmark with its disparity truth.
struct KittiScene2015 {
  std::string name;  ///< six digits, e.g. "000002"
  StereoRig rig;
  cv::Mat1b left, right;
  cv::Mat1f truth_px;      ///< disp_occ_0; kNoTruth on pixels without truth
  cv::Mat1f truth_noc_px;  ///< disp_noc_0, without occluded pixels; empty if it is missing
  cv::Mat1b vehicles;      ///< 255 on moving vehicles (obj_map > 0)
};
KittiScene2015 readKittiScene2015(const std::string& training_dir, const std::string& scene);

}  // namespace predictive_stereo
