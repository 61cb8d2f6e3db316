#include "detection/frame_comparison.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "parallel/tasks.h"
#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detection/frame_comparison.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "detection/row_motion-inl.h"

#ifndef PREDICTIVE_STEREO_LATTICE_ROW
#define PREDICTIVE_STEREO_LATTICE_ROW
namespace predictive_stereo {

// Lattice points of one row, and the previous image.
struct LatticeRow {
  PastMap past;               // the previous image at half resolution, continuous in memory
  const float* disparity_px;  // of the points
  int x, y;                   // pixel of the first point
  int width;                  // points
  const uint8_t* grey;        // current grey values of the points
  const uint8_t* before;      // those of the previous image
};

// Points with smaller disparities do not show motion.
constexpr float kLeastShowing_px = 0.5f;
// Side of the squares over which comparisons are summed, and their reach from the centre.
constexpr int kComparedSide = 5, kComparedReach = kComparedSide / 2;
// Rows from kComparedReach above to kComparedReach below, each with kComparedReach more points
// before its first and after its last one. They are 0 outside the map.
using SurroundingRows = const float* const*;

}  // namespace predictive_stereo
#endif

PREDICTIVE_STEREO_BEGIN_KERNELS;

// Short loops without branches, which compilers vectorise. Intermediate results stay in the first
// cache.
constexpr int kChunk = 256;

HWY_INLINE float greyOf(uint32_t lowest_byte) {
  return static_cast<float>(static_cast<int32_t>(lowest_byte & 255u));
}

// Current grey value - previous grey value.
// @param difference  0 where unknown.
// @param known  1, or 0 for points without a disparity and those outside of the previous image.
HWY_NOINLINE void compareRow(const LatticeRow& row, float* HWY_RESTRICT difference,
                             float* HWY_RESTRICT known) {
  if (row.past.columns < 2 || row.past.rows < 2) {
    std::fill_n(difference, row.width, 0.0f);
    std::fill_n(known, row.width, 0.0f);
    return;
  }
  const RowMotion motion(row.past, row.y);
  const auto end_x = static_cast<float>(2 * (row.past.columns - 1)),
             end_y = static_cast<float>(2 * (row.past.rows - 1));
  const int step = row.past.stride;
  const uint8_t *const before = row.before, *const below = before + step;
  float is_seen[kChunk], fx[kChunk], fy[kChunk];
  int32_t offset[kChunk];
  uint32_t corners[kChunk];  // upper left, upper right, lower left, lower right
  for (int first = 0; first < row.width; first += kChunk) {
    const int n = std::min(kChunk, row.width - first), x0 = row.x + 2 * first;
    const float* HWY_RESTRICT disparity = row.disparity_px + first;
    const uint8_t* HWY_RESTRICT grey = row.grey + first;
    for (int i = 0; i < n; ++i) {
      const auto at = static_cast<float>(x0 + 2 * i);
      const float d = disparity[i];
      const float w = motion.w(at, d);
      const float sx = motion.x(at, d) / w, sy = motion.y(at, d) / w, sd = motion.d(at, d) / w;
      const bool seen =
          (d >= kLeastShowing_px) & (sx >= 0) & (sy >= 0) & (sx < end_x) & (sy < end_y) & (sd > 0);
      const float x = seen ? 0.5f * sx : 0.0f, y = seen ? 0.5f * sy : 0.0f;
      const auto column = static_cast<int32_t>(x), line = static_cast<int32_t>(y);
      is_seen[i] = seen ? 1.0f : 0.0f;
      fx[i] = x - static_cast<float>(column);
      fy[i] = y - static_cast<float>(line);
      offset[i] = line * step + column;
    }
    for (int i = 0; i < n; ++i) {
      auto* const bytes = reinterpret_cast<uint8_t*>(corners + i);
      std::memcpy(bytes, before + offset[i], 2);
      std::memcpy(bytes + 2, below + offset[i], 2);
    }
    for (int i = 0; i < n; ++i) {
      const float a = greyOf(corners[i]), b = greyOf(corners[i] >> 8), c = greyOf(corners[i] >> 16),
                  d = greyOf(corners[i] >> 24);
      const float top = a + fx[i] * (b - a), bottom = c + fx[i] * (d - c);
      const float then = top + fy[i] * (bottom - top);
      difference[first + i] = is_seen[i] * (greyOf(grey[i]) - then);
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

// |difference - its mean over the known points of the square|, 0 where unknown, and the number of
// known points of the square.
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

// Mean deviation of the known points of the square; unknown if the point itself is not known, or if
// fewer than half of them are.
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

PREDICTIVE_STEREO_END_KERNELS;

#if HWY_ONCE
namespace predictive_stereo {
namespace {

HWY_EXPORT(compareRow);
HWY_EXPORT(deviationRow);
HWY_EXPORT(mismatchRow);

// The last kComparedSide rows of a map, with a border of kComparedReach zeros on both sides.
class LastRows {
 public:
  explicit LastRows(int width) : rows_(kComparedSide, width + 2 * kComparedReach, 0.0f) {}
  float* row(int v) { return withBorder(v) + kComparedReach; }
  void clear(int v) { std::fill_n(withBorder(v), rows_.cols, 0.0f); }
  /// From v - kComparedReach to v + kComparedReach, with their borders.
  std::array<const float*, kComparedSide> around(int v) {
    std::array<const float*, kComparedSide> rows;
    for (int k = 0; k < kComparedSide; ++k) rows[k] = withBorder(v + k - kComparedReach);
    return rows;
  }

 private:
  float* withBorder(int v) { return rows_[(v + 2 * kComparedSide) % kComparedSide]; }
  cv::Mat1f rows_;
};

}  // namespace

void compareFrames(const ImagePyramid& current, const cv::Mat1f& lattice_px,
                   const ImagePyramid& previous, const SourceOf& source_of, const cv::Rect& area,
                   cv::Mat1f& mismatch) {
  const cv::Mat1b& now = current.level(1);
  const cv::Mat1b& before = previous.level(1);
  CV_Assert(before.isContinuous());
  const PastMap past{source_of.H().data(), before.cols, before.cols, before.rows};
  mismatch.create(area.size());
  const int rows = area.height;
  const auto exists = [rows](int v) { return v >= 0 && v < rows; };
  // One pass over the rows of a band; rows that are needed again are kept.
  const auto compareBand = [&](const cv::Range& band) {
    LastRows difference(area.width), known(area.width), deviation(area.width), count(area.width);
    const auto compare = [&](int v) {
      if (!exists(v)) return difference.clear(v), known.clear(v);
      const int x = 2 * area.x, y = area.y + v;
      HWY_DYNAMIC_DISPATCH(compareRow)
      ({past, lattice_px[y] + area.x, x, 2 * y, area.width, now[y] + area.x, before.data},
       difference.row(v), known.row(v));
    };
    const auto deviate = [&](int v) {
      if (!exists(v)) return deviation.clear(v);
      HWY_DYNAMIC_DISPATCH(deviationRow)
      (difference.around(v).data(), known.around(v).data(), area.width, deviation.row(v),
       count.row(v));
    };
    for (int v = band.start - 2 * kComparedReach; v < band.start + 2 * kComparedReach; ++v) {
      compare(v);
      if (v >= band.start) deviate(v - kComparedReach);
    }
    for (int v = band.start; v < band.end; ++v) {
      compare(v + 2 * kComparedReach);
      deviate(v + kComparedReach);
      HWY_DYNAMIC_DISPATCH(mismatchRow)
      (deviation.around(v).data(), known.row(v), count.row(v), area.width, mismatch[v]);
    }
  };
  parallelFor(cv::Range(0, rows), compareBand, cv::getNumThreads());
}

}  // namespace predictive_stereo
#endif
