#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "detection/frame_history.h"

namespace predictive_stereo {

/// Displacement of a group of points.
struct ShiftFound {
  cv::Point2f shift_px;  ///< relative to a static world
  float gain = 0;        ///< mismatch without shift / mismatch with this one
};

/// Largest search range to the left and right, in lattice points.
constexpr int kSearchReach = 40;

/// Displacement of a group of lattice points in the past frame, relative to a static world, by
/// exhaustive search: for objects that move too far for Lucas-Kanade.
/// @param reach  search range to the left and right, in lattice points; at most kSearchReach.
/// @returns the shift with the lowest mean zero-mean difference; none if too few points stay in the
///   image.
std::optional<ShiftFound> searchShift(const PastView& view, const std::vector<cv::Point>& points,
                                      int reach = kSearchReach);

/// Largest number of samples: sums of their differences fit into 16 bits.
constexpr int kMostShiftedSamples = 48;
/// Trials that are computed at once; the size of `total` must be a multiple of it.
constexpr int kShiftBlock = 16;

/// The loop of searchShift over shifts along a row, the same on every SIMD target. Compares n
/// samples with the image at shifts of 0, 2, 4, ... columns. `total` is the sum over the samples of
/// |n difference - sum of all differences|, which is n^2 times the mean absolute difference after
/// subtracting the mean difference.
/// @param grey  current grey values of the samples.
/// @param before  position of each sample in the previous image at the first trial. 2 * trials
///   bytes are read from there, with trials rounded up to whole blocks.
void totalsOfShifts(const uint8_t* grey, const uint8_t* const* before, int samples, int trials,
                    int32_t* total);

}  // namespace predictive_stereo
