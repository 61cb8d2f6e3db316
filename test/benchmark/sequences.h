/// Sequences of the benchmarks.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "evaluation/sequence.h"

namespace predictive_stereo {

/// The synthetic street, with a row misalignment of the right camera as in real rigs.
std::unique_ptr<Sequence> misalignedStreet(int frames, cv::Size size = {1242, 375});

/// One pair of image files, repeated `frames` times, as from a standing camera. The calibration is
/// arbitrary.
/// @throws std::runtime_error if a file cannot be read or the sizes differ.
std::unique_ptr<Sequence> pairSequence(const std::string& left_file, const std::string& right_file,
                                       int frames);

/// Opens the sequence of two command-line arguments: two image files, a day's folder and a drive of
/// KITTI's raw recordings, or the training folder and a scene of KITTI 2012.
/// @param frames  number of repetitions of two image files.
std::unique_ptr<Sequence> openSequence(const std::string& first, const std::string& second,
                                       int frames);

}  // namespace predictive_stereo
