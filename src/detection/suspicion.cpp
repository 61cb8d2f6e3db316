#include "detection/suspicion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "detection/patches.h"
#include "parallel/tasks.h"
#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detection/suspicion.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef PREDICTIVE_STEREO_SUSPICION_CELL
#define PREDICTIVE_STEREO_SUSPICION_CELL
namespace predictive_stereo {

// Side of the squares over which texture is summed, and their reach from the centre.
constexpr int kTextureSide = 5, kTextureReach = kTextureSide / 2;
constexpr int kCell = 4;  // side of a cell [lattice points]

}  // namespace predictive_stereo
#endif

PREDICTIVE_STEREO_BEGIN_KERNELS;

constexpr int kChunk = 128;
constexpr int kSquare = kTextureSide * kTextureSide;
static_assert(kTextureSide == 5, "sums are written out, and fit into 16 bits");

// Sums over five rows, from column u on.
template <class T, class Sum>
HWY_INLINE void sumColumns(const T* const rows[kTextureSide], int u, int n,
                           Sum* HWY_RESTRICT sums) {
  const T *r0 = rows[0] + u, *r1 = rows[1] + u, *r2 = rows[2] + u, *r3 = rows[3] + u,
          *r4 = rows[4] + u;
  for (int i = 0; i < n; ++i) sums[i] = static_cast<Sum>(r0[i] + r1[i] + r2[i] + r3[i] + r4[i]);
}

// 25 |grey - mean grey over the square| for each point of the middle one of five rows. 0 for the
// first and last kTextureReach points, which have no such square.
HWY_NOINLINE void greyDeviationRow(const uint8_t* const rows[kTextureSide], int width,
                                   uint16_t* HWY_RESTRICT deviation) {
  const int edge = std::min(kTextureReach, width);
  std::fill_n(deviation, edge, uint16_t{0});
  std::fill_n(deviation + width - edge, edge, uint16_t{0});
  const uint8_t* const middle = rows[kTextureReach];
  int16_t columns[kChunk + 2 * kTextureReach];
  for (int u = kTextureReach; u < width - kTextureReach; u += kChunk) {
    const int n = std::min(kChunk, width - kTextureReach - u);
    sumColumns(rows, u - kTextureReach, n + 2 * kTextureReach, columns);
    for (int i = 0; i < n; ++i) {
      const auto sum = static_cast<int16_t>(columns[i] + columns[i + 1] + columns[i + 2] +
                                            columns[i + 3] + columns[i + 4]);
      const auto scaled = static_cast<int16_t>(kSquare * middle[u + i]);
      deviation[u + i] = static_cast<uint16_t>(std::max(scaled, sum) - std::min(scaled, sum));
    }
  }
}

// Mean of `deviations` / 25 over the square. Not for the first and last kTextureReach points.
HWY_NOINLINE void textureRow(const uint16_t* const deviations[kTextureSide], int width,
                             float* HWY_RESTRICT texture) {
  int32_t columns[kChunk + 2 * kTextureReach];
  for (int u = kTextureReach; u < width - kTextureReach; u += kChunk) {
    const int n = std::min(kChunk, width - kTextureReach - u);
    sumColumns(deviations, u - kTextureReach, n + 2 * kTextureReach, columns);
    for (int i = 0; i < n; ++i) {
      const int32_t sum =
          columns[i] + columns[i + 1] + columns[i + 2] + columns[i + 3] + columns[i + 4];
      texture[u + i] = static_cast<float>(sum) / (kSquare * kSquare);
    }
  }
}

// mismatch / (texture + noise); 0 if the mismatch is negative (unknown).
HWY_NOINLINE void suspicionRow(const float* HWY_RESTRICT texture,
                               const float* HWY_RESTRICT mismatch, int count, float noise,
                               float* HWY_RESTRICT suspicion) {
  for (int i = 0; i < count; ++i)
    suspicion[i] = mismatch[i] >= 0 ? mismatch[i] / (texture[i] + noise) : 0.0f;
}

// The first maximum of a cell, without branches, which would be unpredictable.
HWY_INLINE int32_t placeOfLargest(const float* const rows[kCell], int first) {
  float largest = rows[0][first];
  for (int k = 0; k < kCell; ++k)
    for (int i = 0; i < kCell; ++i) largest = std::max(largest, rows[k][first + i]);
  uint32_t places = 0;
  for (int k = 0; k < kCell; ++k)
    for (int i = 0; i < kCell; ++i)
      places |= (rows[k][first + i] == largest ? 1u : 0u) << (kCell * k + i);
  return static_cast<int32_t>(hwy::Num0BitsBelowLS1Bit_Nonzero32(places));
}

// Finds cells with a maximum of at least `least`; returns their number.
// @param rows  kCell rows, from the first cell's first point on.
// @param found  indices of these cells.
// @param worst  kCell * row + column of the maximum in each of them; of the first one of equals.
HWY_NOINLINE int suspiciousCells(const float* const rows[kCell], int cells, float least,
                                 int32_t* HWY_RESTRICT found, int32_t* HWY_RESTRICT worst) {
  static_assert(kCell == 4, "written out");
  int count = 0;
  float largest[kChunk];
  for (int first = 0; first < cells; first += kChunk / kCell) {
    const int n = std::min(kChunk / kCell, cells - first);
    const float *r0 = rows[0] + kCell * first, *r1 = rows[1] + kCell * first,
                *r2 = rows[2] + kCell * first, *r3 = rows[3] + kCell * first;
    for (int i = 0; i < kCell * n; ++i) {
      const float upper = r0[i] > r1[i] ? r0[i] : r1[i], lower = r2[i] > r3[i] ? r2[i] : r3[i];
      largest[i] = upper > lower ? upper : lower;
    }
    for (int c = 0; c < n; ++c) {
      const float* of_cell = largest + kCell * c;
      found[count] = first + c;
      count += (of_cell[0] >= least) | (of_cell[1] >= least) | (of_cell[2] >= least) |
               (of_cell[3] >= least);
    }
  }
  for (int k = 0; k < count; ++k) worst[k] = placeOfLargest(rows, kCell * found[k]);
  return count;
}

PREDICTIVE_STEREO_END_KERNELS;

#if HWY_ONCE
namespace predictive_stereo {
namespace {

HWY_EXPORT(greyDeviationRow);
HWY_EXPORT(textureRow);
HWY_EXPORT(suspicionRow);
HWY_EXPORT(suspiciousCells);

constexpr int kMargin = 5;  // lattice points along the border that are left out
static_assert(kMargin >= 2 * kTextureReach, "texture is not known closer to the border");

template <class Map>
auto rowsAround(const Map& map, int v) {
  std::array<const typename Map::value_type*, kTextureSide> rows;
  for (int k = 0; k < kTextureSide; ++k) rows[k] = map[v + k - kTextureReach];
  return rows;
}

// Whether most pixels around a pixel have a similar disparity.
bool isWithinSurface(const FrameView& frame, cv::Point p) {
  constexpr int kReach_px = 4;
  const int kFewestAlike = 6;  // of nine
  const cv::Mat1f& disparity_px = frame.input.measured_disparity_px;
  const float d = disparity_px(p);
  int alike = 0;
  for (int dy = -kReach_px; dy <= kReach_px; dy += kReach_px)
    for (int dx = -kReach_px; dx <= kReach_px; dx += kReach_px) {
      const float other = disparity_px(p.y + dy, p.x + dx);
      alike += frame.range.isValid(other) && std::abs(other - d) <= 1 + 0.05f * d;
    }
  return alike >= kFewestAlike;
}

static_assert(2 * kPatchReach + 1 == GreyPatch::kSide);
constexpr int kAround_px = 4;               // distance of the neighbours whose disparity is tried
constexpr float kDisparityError_px = 1.0f;  // of the point's own disparity
constexpr float kSameDisparity_px = 0.5f;
constexpr double kFastestAway_mps = 30;  // of an object that moves along the line of sight
constexpr float kHidingMargin_px = 1.0f;

// Whether a static point was occluded in the past frame: at its position there was a surface so
// much nearer that it cannot be the same one, even if it moves with the camera.
bool wasHidden(const PastView& view, cv::Point pixel) {
  const cv::Mat1f& past_px = view.past.frame->disparity_px;
  const Eigen::Vector3f from = view.staticSource(pixel);
  const int x = cvRound(from.x()), y = cvRound(from.y());
  if (!(from.z() > 0) || x < 0 || y < 0 || x >= past_px.cols || y >= past_px.rows) return false;
  const auto disparity_times_depth = static_cast<float>(view.rig().disparityTimesDepth());
  const auto nearer_m = static_cast<float>(kFastestAway_mps * view.past.seconds);
  const float before = past_px(y, x);
  const float hiding_m = disparity_times_depth / from.z() - nearer_m;
  return view.isKnown(before) && before > from.z() + kHidingMargin_px &&
         before * hiding_m > disparity_times_depth;
}

// Bytes of a patch at a sub-pixel position, copied if a read would leave the image.
struct PatchBytes {
  const uint8_t* upper_left;
  std::ptrdiff_t stride;
  uint8_t copy[kPatchRows * kPatchColumns];

  PatchBytes(const cv::Mat1b& image, int column, int row)
      : upper_left(image[row] + column), stride(static_cast<std::ptrdiff_t>(image.step)) {
    if (column + kPatchColumns <= image.cols && row + kPatchRows <= image.rows) return;
    for (int v = 0; v < kPatchRows; ++v)
      for (int u = 0; u < kPatchColumns; ++u)
        copy[kPatchColumns * v + u] =
            image(std::min(row + v, image.rows - 1), std::min(column + u, image.cols - 1));
    upper_left = copy;
    stride = kPatchColumns;
  }
  PatchBytes(const PatchBytes&) = delete;
};

bool isExplained(const PastView& view, cv::Point p) {
  const float own = view.disparity_px()(p);
  const PatchBytes here(view.images().level(1), p.x / 2 - kPatchReach, p.y / 2 - kPatchReach);
  GreyPatch now;
  patchBetween(here.upper_left, here.stride, 0, 0, now);
  const float most =
      static_cast<float>(view.params().min_mismatch) * (patchTexture(now) + kGreyNoise);
  const cv::Mat1b& previous = view.past_images().level(1);
  const auto end_x = static_cast<float>(previous.cols - kPatchReach - 1),
             end_y = static_cast<float>(previous.rows - kPatchReach - 1);
  const auto explains = [&](float disparity) {
    const Eigen::Vector3f from =
        view.static_source(static_cast<float>(p.x), static_cast<float>(p.y), disparity);
    const float x = 0.5f * from.x(), y = 0.5f * from.y();
    if (!(x >= kPatchReach && y >= kPatchReach && x < end_x && y < end_y)) return false;
    const int column = static_cast<int>(x), row = static_cast<int>(y);
    const PatchBytes then(previous, column - kPatchReach, row - kPatchReach);
    return patchDifference(now, then.upper_left, then.stride, x - static_cast<float>(column),
                           y - static_cast<float>(row)) < most;
  };
  for (float error : {0.0f, kDisparityError_px, -kDisparityError_px})
    if (own + error > 0 && explains(own + error)) return true;
  for (int dy = -kAround_px; dy <= kAround_px; dy += kAround_px)
    for (int dx = -kAround_px; dx <= kAround_px; dx += kAround_px) {
      const float other = view.disparity_px()(p.y + dy, p.x + dx);
      if (view.isKnown(other) && other > 0 && std::abs(other - own) > kSameDisparity_px &&
          explains(other))
        return true;
    }
  return false;
}

}  // namespace

void greyTexture(const cv::Mat1b& grey, cv::Mat1f& texture) {
  texture.create(grey.size());
  const int first = 2 * kTextureReach, last = std::max(grey.rows - first, first);
  const auto ofBand = [&](const cv::Range& band) {
    cv::Mat1w deviation(band.size() + 2 * kTextureReach, grey.cols);
    for (int k = 0; k < deviation.rows; ++k) HWY_DYNAMIC_DISPATCH(greyDeviationRow)
    (rowsAround(grey, band.start - kTextureReach + k).data(), grey.cols, deviation[k]);
    for (int v = band.start; v < band.end; ++v) HWY_DYNAMIC_DISPATCH(textureRow)
    (rowsAround(deviation, v - band.start + kTextureReach).data(), grey.cols, texture[v]);
  };
  parallelFor(cv::Range(first, last), ofBand, cv::getNumThreads());
}

Suspects findSuspects(const FrameView& frame, const cv::Mat1f& texture, const cv::Mat1f& mismatch) {
  const int rows = std::max(texture.rows - 2 * kMargin, 0) / kCell;
  const int columns = std::max(texture.cols - 2 * kMargin, 0) / kCell;
  // A map without columns has no rows of cells.
  std::vector<int> cells_of_row(static_cast<size_t>(columns > 0 ? rows : 0), 0);
  std::vector<std::vector<cv::Point>> points_of_row(cells_of_row.size());
  const auto least = static_cast<float>(frame.params.min_mismatch);
  parallelFor(cv::Range(0, static_cast<int>(cells_of_row.size())), [&](const cv::Range& part) {
    cv::Mat1f suspicion(kCell, kCell * columns);
    std::vector<int32_t> cells(static_cast<size_t>(columns)), worst(cells.size());
    for (int r = part.start; r < part.end; ++r) {
      const int first = kMargin + r * kCell;
      const float* of_cells[kCell];
      for (int k = 0; k < kCell; ++k) {
        HWY_DYNAMIC_DISPATCH(suspicionRow)
        (texture[first + k] + kMargin, mismatch[first + k] + kMargin, suspicion.cols, kGreyNoise,
         suspicion[k]);
        of_cells[k] = suspicion[k];
      }
      const int suspicious = HWY_DYNAMIC_DISPATCH(suspiciousCells)(of_cells, columns, least,
                                                                   cells.data(), worst.data());
      cells_of_row[static_cast<size_t>(r)] = suspicious;
      for (size_t k = 0; k < static_cast<size_t>(suspicious); ++k) {
        const cv::Point at(kMargin + cells[k] * kCell + worst[k] % kCell, first + worst[k] / kCell);
        if (!frame.level.isLevel(at) && isWithinSurface(frame, 2 * at))
          points_of_row[static_cast<size_t>(r)].push_back(2 * at);
      }
    }
  });
  Suspects suspects;
  const int suspicious = std::accumulate(cells_of_row.begin(), cells_of_row.end(), 0);
  suspects.share = static_cast<double>(suspicious) / std::max(rows * columns, 1);
  for (const auto& of_row : points_of_row)
    suspects.points_px.insert(suspects.points_px.end(), of_row.begin(), of_row.end());
  return suspects;
}

std::vector<cv::Point> unexplainedPoints(const PastView& view,
                                         const std::vector<cv::Point>& points_px) {
  const size_t step = (points_px.size() + kMostSuspects - 1) / kMostSuspects;
  std::vector<uint8_t> unexplained(step ? (points_px.size() + step - 1) / step : 0);
  parallelForEach(static_cast<int>(unexplained.size()), [&](int i) {
    const cv::Point p = points_px[step * static_cast<size_t>(i)];
    const float d = view.disparity_px()(p);
    unexplained[static_cast<size_t>(i)] =
        view.isKnown(d) && d > 0 && !wasHidden(view, p) && !isExplained(view, p);
  });
  std::vector<cv::Point> kept;
  for (size_t i = 0; i < unexplained.size(); ++i)
    if (unexplained[i]) kept.push_back(points_px[step * i]);
  return kept;
}

}  // namespace predictive_stereo
#endif
