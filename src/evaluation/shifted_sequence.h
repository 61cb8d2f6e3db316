#pragma once

#include <memory>

#include "evaluation/sequence.h"

namespace predictive_stereo {

/// The right image moved by so many columns to the right (Lanczos interpolation, borders
/// replicated), as after a small turn of that camera.
cv::Mat1b shiftedRight(const cv::Mat1b& right, double shift_px);

/// A sequence whose right camera was turned after its calibration: everything is as in the given
/// one, but the right images are shifted.
std::unique_ptr<Sequence> shiftedRightSequence(std::unique_ptr<Sequence> sequence, double shift_px);

}  // namespace predictive_stereo
