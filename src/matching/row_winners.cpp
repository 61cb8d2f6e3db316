#include "matching/row_winners.h"

#include <cstdlib>

#include "matching/winner.h"

namespace predictive_stereo {

void RowWinners::resize(int width) {
  for (auto* values : {&index, &cost, &below, &above, &runner_up}) values->resize(width);
  right_index.resize(width);
}

void describeRow(const RowWinners& winners, const MatcherParams& params, int y,
                 const uint8_t* first, const uint16_t* width, Match& match) {
  const int columns = match.disparity_px.cols;
  const int min_disparity = params.range.min_disparity, count = params.range.count;
  const int tolerance = params.left_right_tolerance_px;
  const float invalid = params.range.invalid();
  const int path_shift = params.paths == PathSet::kAll8 ? 3 : 2;
  float* disparity_px = match.disparity_px[y];
  uint8_t* ambiguities = match.ambiguity[y];
  uint8_t* costs = match.cost[y];
  uint8_t* at_border = match.at_range_border[y];

  for (int x = 0; x < columns; ++x) {
    if (width && width[x] == 0) {
      disparity_px[x] = invalid;
      ambiguities[x] = costs[x] = 255;
      at_border[x] = 0;
      continue;
    }
    const int begin = first ? first[x] : 0, end = begin + (width ? width[x] : count);
    Winner winner;
    winner.index = winners.index[x];
    winner.cost = winners.cost[x];
    winner.below = winners.below[x];
    winner.above = winners.above[x];
    winner.runner_up = winners.runner_up[x];
    winner.inside = winner.index > begin && winner.index < end - 1;
    ambiguities[x] = ambiguity(winner);
    costs[x] = static_cast<uint8_t>(winner.cost >> path_shift);
    const bool at_interval_border = winner.index == 0 || winner.index == count - 1;
    at_border[x] = !winner.inside && !at_interval_border ? 255 : 0;

    const int disparity = min_disparity + winner.index;
    bool agrees = tolerance < 0;
    const int right_x = x - disparity;
    if (!agrees && right_x >= 0 && right_x < columns)
      agrees = std::abs(winners.right_index[right_x] - winner.index) <= tolerance;
    disparity_px[x] = agrees ? static_cast<float>(disparity) + subpixelOffset(winner) : invalid;
  }
}

}  // namespace predictive_stereo
