/// The loop of searchShift over shifts along a row, compiled for every SIMD target and dispatched
/// at run time. Every target gives the same results.
#pragma once

#include <cstdint>

namespace predictive_stereo {

/// Samples that may be compared at once: sums of their differences fit into 16 bits.
constexpr int kMostShiftedSamples = 48;
/// Trials that are computed at once: `total` has to have room for a multiple of it.
constexpr int kShiftBlock = 16;

/// Of samples that are compared with the image at shifts of 0, 2, 4, ... columns: sum over the
/// samples of |n difference - sum of all differences|, n being their number; that is n^2 times the
/// mean absolute difference after the mean difference is taken away.
/// @param grey  of the samples now.
/// @param before  of each sample where the first trial puts it. Bytes up to 2 x trials, rounded up
///   to whole blocks, are read.
void totalsOfShifts(const uint8_t* grey, const uint8_t* const* before, int samples, int trials,
                    int32_t* total);

}  // namespace predictive_stereo
