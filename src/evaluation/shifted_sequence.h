#pragma once

#include <memory>

#include "evaluation/sequence.h"

namespace predictive_stereo {

/// The right image, shifted to the right (Lanczos interpolation, borders replicated), as after a
/// small turn of that camera.
cv::Mat1b shiftedRight(const cv::Mat1b& right, double shift_px);

/// The given sequence with shifted right images, as if the right camera had been turned after its
/// calibration.
std::unique_ptr<Sequence> shiftedRightSequence(std::unique_ptr<Sequence> sequence, double shift_px);

}  // namespace predictive_stereo
