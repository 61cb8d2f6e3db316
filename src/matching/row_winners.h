/// The winners of a row, as kernels hand them over, and their translation into a Match.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "predictive_stereo/matcher.h"

namespace predictive_stereo {

/// Members of `Winner`, one entry per pixel of the left image, and the right image's winners.
/// Entries of pixels that are not searched mean nothing.
struct RowWinners {
  static constexpr int16_t kNoIndex = -1000;

  std::vector<uint8_t> index, cost, below, above, runner_up;
  std::vector<int16_t> right_index;  ///< of each right pixel; kNoIndex: none below 255

  void resize(int width);
};

/// Sub-pixel disparity, left-right check and the observables of row y. The maps of `match` have
/// their sizes already.
/// @param first, width  the windows of this row; nullptr: everything was searched.
void describeRow(const RowWinners& winners, const MatcherParams& params, int y,
                 const uint8_t* first, const uint16_t* width, Match& match);

}  // namespace predictive_stereo
