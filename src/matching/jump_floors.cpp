#include "matching/jump_floors.h"

#include <algorithm>
#include <cstring>

#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

constexpr int kReach =
    2;  // pixels on each side, beyond the edge's own two, where the step must last

/// Pointers are separate arguments that do not overlap: compilers vectorise this loop only then.
void floorsBetween(const uint8_t* near_before, const uint8_t* near_after, const uint8_t* far_before,
                   const uint8_t* far_after, int count, uint8_t least_step, uint8_t floor,
                   uint8_t* __restrict floors) {
  for (int x = 0; x < count; ++x) {
    const uint8_t a = near_before[x], b = near_after[x], c = far_before[x], d = far_after[x];
    const auto near_step = static_cast<uint8_t>(std::max(a, b) - std::min(a, b));
    const auto far_step = static_cast<uint8_t>(std::max(c, d) - std::min(c, d));
    floors[x] = std::min(near_step, far_step) >= least_step ? floor : uint8_t{0};
  }
}

}  // namespace

void JumpFloors::build(const cv::Mat1b& left, const MatcherParams& params) {
  constexpr int kMargin = 16;
  const int width = left.cols, height = left.rows;
  stride_ = static_cast<size_t>(width) + 1 + kMargin;
  const size_t bytes = stride_ * (static_cast<size_t>(height) + 1);
  across_.reserve(bytes);
  down_.reserve(bytes);
  const int lowered = params.edge_step > 0 ? std::max(params.p2 - params.p2_edge, 0) : 0;
  if (lowered == 0) {
    std::memset(across_.data(), 0, bytes);
    std::memset(down_.data(), 0, bytes);
    return;
  }
  const auto floor = static_cast<uint8_t>(lowered);
  const auto least_step = static_cast<uint8_t>(params.edge_step);
  const auto row = [&](int y) { return left[std::clamp(y, 0, height - 1)]; };
  parallelFor(cv::Range(0, height + 1), [&](const cv::Range& rows) {
    cv::AutoBuffer<uint8_t, 4096> padded(static_cast<size_t>(width + 2 * (kReach + 1)));
    for (int y = rows.start; y < rows.end; ++y) {
      floorsBetween(row(y - 1), row(y), row(y - 1 - kReach), row(y + kReach), width, least_step,
                    floor, down_.data() + offsetOf(y));
      if (y == height) break;
      // The row with replicated borders.
      constexpr int kBeside = kReach + 1;
      uint8_t* const here = padded.data() + kBeside;
      std::fill_n(padded.data(), kBeside, left(y, 0));
      std::copy_n(left[y], width, here);
      std::fill_n(here + width, kBeside, left(y, width - 1));
      floorsBetween(here - 1, here, here - 1 - kReach, here + kReach, width + 1, least_step, floor,
                    across_.data() + offsetOf(y));
    }
  });
}

}  // namespace predictive_stereo
