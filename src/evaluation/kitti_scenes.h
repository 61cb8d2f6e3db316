/// Training scenes of KITTI's stereo benchmarks.
///
/// Every failure is a std::runtime_error with the name of the file or folder.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "evaluation/sequence.h"

namespace predictive_stereo {

/// KITTI 2012: static scenes. 2015: with vehicles that move; mostly there is one frame.
enum class KittiStereo { k2012, k2015 };

/// The scenes with truth, six digits each, sorted; at least one.
/// @param training_dir  2012: the folder with image_0, image_1, calib and disp_occ; 2015: that with
///   image_2, image_3, disp_occ_0, obj_map and calib_cam_to_cam.
std::vector<std::string> listKittiScenes(KittiStereo benchmark, const std::string& training_dir);

/// A scene. Its last frame has truth, that of 2015 also vehicles.
std::unique_ptr<Sequence> kittiScene(KittiStereo benchmark, const std::string& training_dir,
                                     const std::string& scene);

}  // namespace predictive_stereo
