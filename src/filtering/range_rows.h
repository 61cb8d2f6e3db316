/// The loops of the search ranges over one row of pixels, see prediction_rows.h.
#pragma once

#include <algorithm>
#include <cstdint>

namespace predictive_stereo {

/// Ranges of one row. first > last: unknown.
struct RangeRow {
  int16_t* first;
  int16_t* last;
};
struct ConstRangeRow {
  const int16_t* first;
  const int16_t* last;
};

/// The empty range, which does not change a hull.
constexpr int16_t kEmptyFirst = INT16_MAX;
constexpr int16_t kEmptyLast = INT16_MIN;

/// Margin around a disparity: `sigmas` standard deviations, clamped to [least, most]; `least` near
/// edges.
struct Margins {
  float sigmas, least, most;
};
struct PredictedRow {
  const float* disparity_px;
  const float* variance_px2;
  const uint8_t* near_edge;
  const uint8_t* missed_frames;
};
void widenPredicted(const PredictedRow& row, int width, const Margins& margins,
                    float smallest_valid, uint8_t moving, const RangeRow& ranges);

void widenMeasured(const float* disparity_px, int width, float margin_px, float smallest_valid,
                   const RangeRow& ranges);

/// The 3x3 hull: of three rows, then of each pixel with both its neighbours. `column_hull` is
/// scratch memory of `width` pixels.
void hullOfRows(const ConstRangeRow rows[3], int width, const RangeRow& column_hull,
                const RangeRow& hull);

/// Unites `ranges` with those of half resolution.
void uniteWithCoarse(const ConstRangeRow& coarse, int coarse_width, int width,
                     const RangeRow& ranges);

/// Unites `hull` with `ranges`, pixel by pixel.
void uniteRows(const ConstRangeRow& ranges, int width, const RangeRow& hull);

/// Cuts `ranges` to [smallest, largest]; empty ones become `otherwise`.
void cutRanges(const ConstRangeRow& otherwise, int width, int16_t smallest, int16_t largest,
               const RangeRow& ranges);

/// last - first + 1, but at least 0.
inline void widthsOfRow(const ConstRangeRow& ranges, int width, uint16_t* widths) {
  for (int x = 0; x < width; ++x) {
    const auto count = static_cast<int16_t>(ranges.last[x] - ranges.first[x] + 1);
    widths[x] = static_cast<uint16_t>(std::max<int16_t>(count, 0));
  }
}

}  // namespace predictive_stereo
