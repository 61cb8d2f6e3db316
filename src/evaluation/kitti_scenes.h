/// Training scenes of KITTI's stereo benchmarks.
///
/// Every failure is a std::runtime_error with the name of the file or folder.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "evaluation/sequence.h"

namespace predictive_stereo {

/// The scenes with truth, six digits each, sorted; at least one.
/// @param training_dir  the folder with image_0, image_1, calib and disp_occ.
std::vector<std::string> listKittiScenes2012(const std::string& training_dir);
/// @param training_dir  the folder with image_2, image_3, disp_occ_0, obj_map, calib_cam_to_cam.
std::vector<std::string> listKittiScenes2015(const std::string& training_dir);

/// A scene of KITTI 2012, which is static. Its last frame has truth.
std::unique_ptr<Sequence> kittiScene2012Sequence(const std::string& training_dir,
                                                 const std::string& scene);
/// A scene of KITTI 2015. Its last frame, mostly the only one, has truth and vehicles.
std::unique_ptr<Sequence> kittiScene2015Sequence(const std::string& training_dir,
                                                 const std::string& scene);

}  // namespace predictive_stereo
