/// The loop of searchShift over shifts along a row, compiled for every SIMD target and dispatched
/// at run time. Every target gives the same results.
#pragma once

#include <cstdint>

namespace predictive_stereo {

/// Largest number of samples: sums of their differences fit into 16 bits.
constexpr int kMostShiftedSamples = 48;
/// Trials that are computed at once; the size of `total` must be a multiple of it.
constexpr int kShiftBlock = 16;

/// Compares n samples with the image at shifts of 0, 2, 4, ... columns. `total` is the sum over the
/// samples of |n difference - sum of all differences|, which is n^2 times the mean absolute
/// difference after subtracting the mean difference.
/// @param grey  current grey values of the samples.
/// @param before  position of each sample in the previous image at the first trial. 2 * trials
///   bytes are read from there, with trials rounded up to whole blocks.
void totalsOfShifts(const uint8_t* grey, const uint8_t* const* before, int samples, int trials,
                    int32_t* total);

}  // namespace predictive_stereo
