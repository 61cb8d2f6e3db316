#include "odometry/features.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <opencv2/core/utility.hpp>

#include "parallel/tasks.h"
#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "odometry/features.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef PREDICTIVE_STEREO_CORNER_ROWS
#define PREDICTIVE_STEREO_CORNER_ROWS
namespace predictive_stereo {

constexpr int kCircle = 16;
constexpr int kRadius = 3;

}  // namespace predictive_stereo
#endif

PREDICTIVE_STEREO_BEGIN_KERNELS;

// Smallest difference between a pixel and nine successive pixels on the circle that are all darker
// or all brighter; 0 if it does not exceed the threshold. Nine of sixteen pixels contain one of any
// two opposite ones: this gives an early exit.
template <class D>
HWY_INLINE hn::Vec<D> differences(D d, const uint8_t* pixel, const int (&circle)[kCircle],
                                  hn::Vec<D> threshold) {
  using V = hn::Vec<D>;
  const V centre = hn::LoadU(d, pixel);
  const auto around = [&](int k) HWY_ATTR { return hn::LoadU(d, pixel + circle[k % kCircle]); };
  const auto difference = [&](V darkest_bright, V brightest_dark) HWY_ATTR {
    const V larger =
        hn::Max(hn::SaturatedSub(darkest_bright, centre), hn::SaturatedSub(centre, brightest_dark));
    return hn::IfThenZeroElse(hn::Eq(hn::SaturatedSub(larger, threshold), hn::Zero(d)), larger);
  };

  V bright = hn::Set(d, 255), dark = hn::Zero(d);
  for (int k = 0; k < kCircle / 2; k += 2) {
    const V a = around(k), b = around(k + kCircle / 2);
    bright = hn::Min(bright, hn::Max(a, b));
    dark = hn::Max(dark, hn::Min(a, b));
  }
  if (hn::AllTrue(d, hn::Eq(difference(bright, dark), hn::Zero(d)))) return hn::Zero(d);

  // Eight successive pixels from every odd one on; each group is part of two groups of nine.
  V low[kCircle / 2], high[kCircle / 2];
  for (int i = 0; i < kCircle / 2; ++i) {
    const V a = around(2 * i + 1), b = around(2 * i + 2);
    low[i] = hn::Min(a, b);
    high[i] = hn::Max(a, b);
  }
  V low4[kCircle / 2], high4[kCircle / 2];
  for (int i = 0; i < kCircle / 2; ++i) {
    low4[i] = hn::Min(low[i], low[(i + 1) % 8]);
    high4[i] = hn::Max(high[i], high[(i + 1) % 8]);
  }
  bright = hn::Zero(d), dark = hn::Set(d, 255);
  for (int i = 0; i < kCircle / 2; ++i) {
    const V before = around(2 * i), after = around(2 * i + 9);
    const V low8 = hn::Min(low4[i], low4[(i + 2) % 8]);
    const V high8 = hn::Max(high4[i], high4[(i + 2) % 8]);
    bright = hn::Max(bright, hn::Min(low8, hn::Max(before, after)));
    dark = hn::Min(dark, hn::Max(high8, hn::Min(before, after)));
  }
  return difference(bright, dark);
}

// Calls pixels(tag, x) for all pixels of a row, in vectors if the row has room for one. The last
// vector may process pixels a second time.
template <class Pixels>
HWY_INLINE void forRow(int width, const Pixels& pixels) {
  const hn::ScalableTag<uint8_t> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  int x = 0;
  for (; x + lanes <= width; x += lanes) pixels(d, x);
  if (x == width) return;
  if (width >= lanes)
    pixels(d, width - lanes);
  else
    for (; x < width; ++x) pixels(hn::FixedTag<uint8_t, 1>(), x);
}

void differencesOfRow(const uint8_t* row, const int (&circle)[kCircle], int width, int threshold,
                      uint8_t* difference) {
  forRow(width, [&](auto d, int x) HWY_ATTR {
    const auto at_least = hn::Set(d, static_cast<uint8_t>(threshold));
    hn::StoreU(differences(d, row + x, circle, at_least), d, difference + x);
  });
}

// Non-maximum suppression: keeps differences that are larger than those of their eight neighbours.
void peaksOfRow(const uint8_t* above, const uint8_t* row, const uint8_t* below, int width,
                uint8_t* peaks) {
  forRow(width, [&](auto d, int x) HWY_ATTR {
    const auto centre = hn::LoadU(d, row + x);
    auto other = hn::Max(hn::LoadU(d, row + x - 1), hn::LoadU(d, row + x + 1));
    for (const uint8_t* beside : {above, below})
      for (int dx : {-1, 0, 1}) other = hn::Max(other, hn::LoadU(d, beside + x + dx));
    const auto is_none = hn::Eq(hn::SaturatedSub(centre, other), hn::Zero(d));
    hn::StoreU(hn::IfThenZeroElse(is_none, centre), d, peaks + x);
  });
}

// Appends the columns with values above the threshold.
void columnsAbove(const uint8_t* row, int width, int threshold, std::vector<int>& columns) {
  const hn::ScalableTag<uint8_t> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto most = hn::Set(d, static_cast<uint8_t>(threshold));
  int x = 0;
  for (; x + lanes <= width; x += lanes) {
    const auto above = hn::Ne(hn::SaturatedSub(hn::LoadU(d, row + x), most), hn::Zero(d));
    if (hn::AllFalse(d, above)) continue;
    uint64_t bits = 0;
    static_assert(hn::MaxLanes(hn::ScalableTag<uint8_t>()) <= 64, "one word of bits");
    hn::StoreMaskBits(d, above, reinterpret_cast<uint8_t*>(&bits));
    for (; bits != 0; bits &= bits - 1)
      columns.push_back(x + static_cast<int>(hwy::Num0BitsBelowLS1Bit_Nonzero64(bits)));
  }
  for (; x < width; ++x)
    if (row[x] > threshold) columns.push_back(x);
}

PREDICTIVE_STEREO_END_KERNELS;

#if HWY_ONCE
namespace predictive_stereo {
namespace {

HWY_EXPORT(differencesOfRow);
HWY_EXPORT(peaksOfRow);
HWY_EXPORT(columnsAbove);

constexpr int kPerCell = 3;
constexpr float kSmallestDistancePx = 8;
// Smallest scores, tried one after the other until a row of cells has enough corners: first strong
// corners only; dark images need the second.
constexpr std::array<int, 2> kScores = {20, 5};

constexpr auto strongerFirst = [](const FastCorner& a, const FastCorner& b) {
  if (a.score != b.score) return a.score > b.score;
  return a.position.y != b.position.y ? a.position.y < b.position.y : a.position.x < b.position.x;
};

bool farFromAll(cv::Point2f point, const std::vector<cv::Point2f>& others) {
  return std::none_of(others.begin(), others.end(), [&](cv::Point2f other) {
    const cv::Point2f d = point - other;
    return d.dot(d) < kSmallestDistancePx * kSmallestDistancePx;
  });
}

}  // namespace

void FastCorners::find(const cv::Mat1b& image, const cv::Rect& area, int least_score) {
  constexpr int kCircleXY[kCircle][2] = {{0, 3},  {1, 3},  {2, 2},  {3, 1},   {3, 0},   {3, -1},
                                         {2, -2}, {1, -3}, {0, -3}, {-1, -3}, {-2, -2}, {-3, -1},
                                         {-3, 0}, {-3, 1}, {-2, 2}, {-1, 3}};
  int circle[kCircle];
  for (int k = 0; k < kCircle; ++k)
    circle[k] = kCircleXY[k][0] + kCircleXY[k][1] * static_cast<int>(image.step);

  // Non-maximum suppression needs the differences one pixel around the area.
  const cv::Rect inside(kRadius, kRadius, image.cols - 2 * kRadius, image.rows - 2 * kRadius);
  const cv::Rect around =
      cv::Rect(area.x - 1, area.y - 1, area.width + 2, area.height + 2) & inside;
  area_ = area & inside;
  peaks_.resize(static_cast<size_t>(area_.area()));
  if (area_.empty()) return;

  // The differences of three rows.
  const int stride = area_.width + 2;
  cv::AutoBuffer<uint8_t, 8192> memory(static_cast<size_t>(3 * stride));
  std::fill_n(memory.data(), memory.size(), uint8_t{0});
  const auto differences = [&](int y) { return memory.data() + (y + 3) % 3 * stride + 1; };
  const auto compare = [&](int y) {
    if (y < around.y || y >= around.br().y)
      std::fill_n(differences(y) - 1, stride, uint8_t{0});
    else
      HWY_DYNAMIC_DISPATCH(differencesOfRow)
    (image[y] + around.x, circle, around.width, least_score, differences(y) + around.x - area_.x);
  };
  compare(area_.y - 1);
  compare(area_.y);
  for (int y = area_.y; y < area_.br().y; ++y) {
    compare(y + 1);
    HWY_DYNAMIC_DISPATCH(peaksOfRow)
    (differences(y - 1), differences(y), differences(y + 1), area_.width,
     &peaks_[static_cast<size_t>((y - area_.y) * area_.width)]);
  }
}

void FastCorners::append(int least_score, std::vector<FastCorner>& corners) const {
  std::vector<int> columns;
  for (int y = 0; y < area_.height; ++y) {
    const uint8_t* peaks = &peaks_[static_cast<size_t>(y * area_.width)];
    columns.clear();
    HWY_DYNAMIC_DISPATCH(columnsAbove)(peaks, area_.width, least_score, columns);
    for (int x : columns) corners.push_back({{area_.x + x, area_.y + y}, peaks[x] - 1});
  }
}

CornerDetector::Grid::Grid(const cv::Rect& image_area, int count) : area(image_area) {
  // Half of the cells are on sky or road without texture: make room for twice the number.
  const double side = std::sqrt(static_cast<double>(area.area()) * kPerCell / (2.0 * count));
  columns = std::max(1, static_cast<int>(std::lround(area.width / side)));
  rows = std::max(1, static_cast<int>(std::lround(area.height / side)));
}

cv::Rect CornerDetector::Grid::strip(int row) const {
  const int top = area.y + (row * area.height + rows - 1) / rows;
  const int bottom = area.y + ((row + 1) * area.height + rows - 1) / rows;
  return {area.x, top, area.width, bottom - top};
}

void CornerDetector::detect(const cv::Mat1b& image, int count,
                            const std::vector<cv::Point2f>& taken, int border_px,
                            std::vector<cv::Point2f>& corners) {
  const cv::Rect area(border_px, border_px, image.cols - 2 * border_px, image.rows - 2 * border_px);
  if (area.width <= 0 || area.height <= 0) return;
  const Grid grid(area, count);
  cells_.resize(static_cast<size_t>(grid.columns) * grid.rows);
  for (Cell& cell : cells_) {
    cell.vacant = kPerCell;
    cell.taken.clear();
  }
  for (cv::Point2f point : taken) {
    Cell& cell = cells_[grid.row(point.y) * grid.columns + grid.column(point.x)];
    --cell.vacant;
    cell.taken.push_back(point);
  }

  // Work is distributed by strips of cells: the result does not depend on the number of threads.
  std::vector<std::vector<cv::Point2f>> found(grid.rows);
  parallelFor(cv::Range(0, grid.rows), [&](const cv::Range& range) {
    FastCorners fast;
    for (int row = range.start; row < range.end; ++row) fillRow(image, grid, row, fast, found[row]);
  });
  for (const auto& of_row : found) corners.insert(corners.end(), of_row.begin(), of_row.end());
}

void CornerDetector::fillRow(const cv::Mat1b& image, const Grid& grid, int row, FastCorners& fast,
                             std::vector<cv::Point2f>& found) {
  Cell* cells = &cells_[static_cast<size_t>(row) * grid.columns];
  int wanted = 0;
  for (int c = 0; c < grid.columns; ++c) wanted += std::max(0, cells[c].vacant);
  if (wanted == 0) return;
  const auto isWelcome = [&](const FastCorner& candidate) {
    const Cell& cell = cells[grid.column(candidate.position.x)];
    return cell.vacant > 0 && farFromAll(candidate.position, cell.taken);
  };
  fast.find(image, grid.strip(row), kScores.back());
  std::vector<FastCorner> candidates;
  for (int score : kScores) {
    candidates.clear();
    fast.append(score, candidates);
    candidates.erase(std::remove_if(candidates.begin(), candidates.end(), std::not_fn(isWelcome)),
                     candidates.end());
    std::sort(candidates.begin(), candidates.end(), strongerFirst);
    for (const FastCorner& candidate : candidates) {
      if (!isWelcome(candidate)) continue;
      const cv::Point2f point = candidate.position;
      Cell& cell = cells[grid.column(point.x)];
      --cell.vacant;
      --wanted;
      cell.taken.push_back(point);
      found.push_back(point);
    }
    if (3 * wanted < grid.columns * kPerCell) break;
  }
}

}  // namespace predictive_stereo
#endif
