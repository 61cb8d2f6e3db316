#include "detection/comparison_rows.h"

#include <hwy/cache_control.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detection/comparison_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "detection/row_motion-inl.h"

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

// Short loops without branches, which compilers vectorise. Intermediate results stay in the first
// cache.
constexpr int kChunk = 64;

HWY_NOINLINE void projectRow(const LatticeRow& row, float* HWY_RESTRICT source_x,
                             float* HWY_RESTRICT source_y, float* HWY_RESTRICT is_seen) {
  const RowMotion motion(row.H, row.y);
  const auto end_x = static_cast<float>(2 * (row.columns - 1)),
             end_y = static_cast<float>(2 * (row.rows - 1));
  const float smallest = row.smallest_px;
  const float* HWY_RESTRICT disparity = row.disparity_px;
  const int x0 = row.x, width = row.width;
  for (int i = 0; i < width; ++i) {
    const auto x = static_cast<float>(x0 + 2 * i);
    const float d = disparity[2 * i];
    const float w = motion.w(x, d);
    const float sx = motion.x(x, d) / w, sy = motion.y(x, d) / w, sd = motion.d(x, d) / w;
    const bool seen =
        (d >= smallest) & (sx >= 0) & (sy >= 0) & (sx < end_x) & (sy < end_y) & (sd > 0);
    source_x[i] = seen ? sx : 0.0f;
    source_y[i] = seen ? sy : 0.0f;
    is_seen[i] = seen ? 1.0f : 0.0f;
  }
}

HWY_INLINE float greyOf(uint32_t lowest_byte) {
  return static_cast<float>(static_cast<int32_t>(lowest_byte & 255u));
}

HWY_NOINLINE void compareRow(const LatticeRow& row, const RowSources& sources,
                             const uint8_t* HWY_RESTRICT grey, const uint8_t* HWY_RESTRICT before,
                             float* HWY_RESTRICT difference, float* HWY_RESTRICT known) {
  if (row.columns < 2 || row.rows < 2) {
    std::fill_n(difference, row.width, 0.0f);
    std::fill_n(known, row.width, 0.0f);
    return;
  }
  const int step = row.columns;
  float fx[kChunk], fy[kChunk];
  int32_t offset[kChunk];
  uint32_t corners[kChunk];  // upper left, upper right, lower left, lower right
  for (int first = 0; first < row.width; first += kChunk) {
    const int n = std::min(kChunk, row.width - first);
    const float *HWY_RESTRICT source_x = sources.x() + first,
                              *HWY_RESTRICT source_y = sources.y() + first,
                              *HWY_RESTRICT is_seen = sources.seen() + first;
    for (int i = 0; i < n; ++i) {
      const float x = 0.5f * source_x[i], y = 0.5f * source_y[i];
      const auto column = static_cast<int32_t>(x), line = static_cast<int32_t>(y);
      fx[i] = x - static_cast<float>(column);
      fy[i] = y - static_cast<float>(line);
      offset[i] = line * step + column;
    }
    for (int i = 0; i < n; ++i) {
      uint16_t upper, lower;
      std::memcpy(&upper, before + offset[i], 2);
      std::memcpy(&lower, before + offset[i] + step, 2);
      corners[i] = static_cast<uint32_t>(upper) | static_cast<uint32_t>(lower) << 16;
    }
    for (int i = 0; i < n; ++i) {
      const float a = greyOf(corners[i]), b = greyOf(corners[i] >> 8), c = greyOf(corners[i] >> 16),
                  d = greyOf(corners[i] >> 24);
      const float top = a + fx[i] * (b - a), bottom = c + fx[i] * (d - c);
      const float then = top + fy[i] * (bottom - top);
      difference[first + i] = is_seen[i] * (greyOf(grey[first + i]) - then);
      known[first + i] = is_seen[i];
    }
  }
}

// Sums over the squares around points u, u + 1, ...: first over columns, then along the row.
HWY_INLINE void sumOfSquares(SurroundingRows rows, int u, int n, float* HWY_RESTRICT sum) {
  static_assert(kComparedSide == 5, "written out");
  const float *r0 = rows[0] + u, *r1 = rows[1] + u, *r2 = rows[2] + u, *r3 = rows[3] + u,
              *r4 = rows[4] + u;
  float column[kChunk + 2 * kComparedReach];
  for (int i = 0; i < n + 2 * kComparedReach; ++i)
    column[i] = r0[i] + r1[i] + r2[i] + r3[i] + r4[i];
  for (int i = 0; i < n; ++i)
    sum[i] = column[i] + column[i + 1] + column[i + 2] + column[i + 3] + column[i + 4];
}

HWY_NOINLINE void deviationRow(SurroundingRows difference, SurroundingRows known, int width,
                               float* HWY_RESTRICT deviation, float* HWY_RESTRICT count) {
  const float* HWY_RESTRICT d = difference[kComparedReach] + kComparedReach;
  const float* HWY_RESTRICT k = known[kComparedReach] + kComparedReach;
  float sum[kChunk];
  for (int u = 0; u < width; u += kChunk) {
    const int n = std::min(kChunk, width - u);
    sumOfSquares(difference, u, n, sum);
    sumOfSquares(known, u, n, count + u);
    for (int i = 0; i < n; ++i)
      deviation[u + i] = k[u + i] * std::abs(d[u + i] - sum[i] / std::max(count[u + i], 1.0f));
  }
}

HWY_NOINLINE void mismatchRow(SurroundingRows deviation, const float* HWY_RESTRICT known,
                              const float* HWY_RESTRICT count, int width,
                              float* HWY_RESTRICT mismatch) {
  constexpr float kFewest = 0.5f * kComparedSide * kComparedSide;
  float sum[kChunk];
  for (int u = 0; u < width; u += kChunk) {
    const int n = std::min(kChunk, width - u);
    sumOfSquares(deviation, u, n, sum);
    for (int i = 0; i < n; ++i) {
      const float mean = sum[i] / std::max(count[u + i], 1.0f);
      mismatch[u + i] = ((count[u + i] >= kFewest) & (known[u + i] > 0)) ? mean : kUnknownMismatch;
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(projectRow);
HWY_EXPORT(compareRow);
HWY_EXPORT(deviationRow);
HWY_EXPORT(mismatchRow);

void projectRow(const LatticeRow& row, RowSources& sources) {
  HWY_DYNAMIC_DISPATCH(projectRow)
  (row, sources.x(), sources.y(), sources.seen());
}

void compareRow(const LatticeRow& row, const RowSources& sources, const uint8_t* grey,
                const uint8_t* before, float* difference, float* known) {
  HWY_DYNAMIC_DISPATCH(compareRow)(row, sources, grey, before, difference, known);
}

void deviationRow(SurroundingRows difference, SurroundingRows known, int width, float* deviation,
                  float* count) {
  HWY_DYNAMIC_DISPATCH(deviationRow)(difference, known, width, deviation, count);
}

void mismatchRow(SurroundingRows deviation, const float* known, const float* count, int width,
                 float* mismatch) {
  HWY_DYNAMIC_DISPATCH(mismatchRow)(deviation, known, count, width, mismatch);
}

}  // namespace predictive_stereo
#endif
