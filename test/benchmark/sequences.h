/// What the benchmarks run on.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "evaluation/sequence.h"

namespace predictive_stereo {

/// The built-in street, its right camera misaligned by rows as real ones are.
std::unique_ptr<Sequence> misalignedStreet(int frames, cv::Size size = {1242, 375});

/// One pair of image files, `frames` times: as if the camera stood still. The rig is made up.
/// @throws std::runtime_error where a file cannot be read or the sizes differ.
std::unique_ptr<Sequence> pairSequence(const std::string& left_file, const std::string& right_file,
                                       int frames);

/// What two command-line arguments name: two image files, a day's folder and a drive of KITTI's raw
/// recordings, or the training folder and a scene of KITTI 2012.
/// @param frames  how often a pair of files is repeated.
std::unique_ptr<Sequence> openSequence(const std::string& first, const std::string& second,
                                       int frames);

}  // namespace predictive_stereo
