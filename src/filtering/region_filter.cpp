#include "predictive_stereo/region_filter.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "parallel/tasks.h"
#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filtering/region_filter.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

PREDICTIVE_STEREO_BEGIN_KERNELS;

// connected[x]: 1 if both pixels are valid and differ by at most 1 px, else 0.
void connectionsOfRow(const float* pixels, const float* neighbours, int count, float smallest_valid,
                      uint8_t* HWY_RESTRICT connected) {
  for (int x = 0; x < count; ++x) {
    const float a = pixels[x], b = neighbours[x];
    connected[x] = (a >= smallest_valid) & (b >= smallest_valid) & (std::abs(a - b) <= 1.0f);
  }
}

PREDICTIVE_STEREO_END_KERNELS;

#if HWY_ONCE
namespace predictive_stereo {
namespace {

HWY_EXPORT(connectionsOfRow);

constexpr int kBandRows = 32;

}  // namespace

void RegionFilter::filter(const DisparityRange& range, int min_region_px, cv::Mat1f& disparity_px) {
  if (min_region_px <= 1 || disparity_px.empty()) return;
  const int width = disparity_px.cols, height = disparity_px.rows;
  findRuns(disparity_px, static_cast<float>(range.min_disparity));
  // First within bands, which are independent, then across their borders. The order of unions does
  // not depend on the number of threads.
  const int bands = (height + kBandRows - 1) / kBandRows;
  parallelForEach(bands, [&](int band) {
    for (int y = band * kBandRows + 1; y < std::min((band + 1) * kBandRows, height); ++y)
      connectRows(y);
  });
  for (int y = kBandRows; y < height; y += kBandRows) connectRows(y);
  // Parents come before their runs, so after this loop the parent of each run is its root.
  for (int y = 0; y < height; ++y)
    for (int32_t run = y * width; run < y * width + run_count_[y]; ++run)
      runs_[run].parent = runs_[runs_[run].parent].parent;
  parallelForEach(height, [&](int y) {
    for (int32_t run = y * width; run < y * width + run_count_[y]; ++run)
      if (runs_[runs_[run].parent].pixels < min_region_px)
        std::fill(disparity_px[y] + runs_[run].begin, disparity_px[y] + runs_[run].end,
                  range.invalid());
  });
}

void RegionFilter::findRuns(const cv::Mat1f& disparity_px, float smallest_valid) {
  const int width = disparity_px.cols, height = disparity_px.rows;
  across_.create(disparity_px.size());
  down_.create(disparity_px.size());
  runs_.resize(disparity_px.total());
  run_count_.resize(static_cast<size_t>(height));
  parallelForEach(height, [&](int y) {
    const float* const row = disparity_px[y];
    uint8_t* const across = across_[y];
    const auto connect = [&](const float* neighbours, int count, uint8_t* connected) {
      HWY_DYNAMIC_DISPATCH(connectionsOfRow)(row, neighbours, count, smallest_valid, connected);
    };
    connect(row + 1, width - 1, across);
    across[width - 1] = 0;
    if (y + 1 < height) connect(disparity_px[y + 1], width, down_[y]);
    int32_t run = y * width;
    for (int x = 0; x < width; ++x) {
      if (row[x] < smallest_valid) continue;
      int last = x;
      if (across[x] != 0)
        last = static_cast<int>(static_cast<const uint8_t*>(
                                    std::memchr(across + x, 0, static_cast<size_t>(width - x))) -
                                across);
      const int end = last + 1;
      runs_[run] = {x, end, run, end - x};
      ++run;
      x = end - 1;
    }
    run_count_[y] = run - y * width;
  });
}

/// Unites the regions of runs in rows y - 1 and y that overlap and are connected in some column.
void RegionFilter::connectRows(int y) {
  const int width = across_.cols;
  int32_t above = (y - 1) * width, here = y * width;
  const int32_t above_end = above + run_count_[y - 1], here_end = here + run_count_[y];
  const uint8_t* const down = down_[y - 1];
  while (above < above_end && here < here_end) {
    const int begin = std::max(runs_[above].begin, runs_[here].begin);
    const int end = std::min(runs_[above].end, runs_[here].end);
    const bool known = runs_[above].parent == runs_[here].parent;
    if (begin < end && !known &&
        (down[begin] != 0 || std::memchr(down + begin, 1, static_cast<size_t>(end - begin))))
      unite(above, here);
    if (runs_[above].end < runs_[here].end)
      ++above;
    else
      ++here;
  }
}

int32_t RegionFilter::rootOf(int32_t run) {
  while (runs_[run].parent != run) {
    runs_[run].parent = runs_[runs_[run].parent].parent;
    run = runs_[run].parent;
  }
  return run;
}

/// The first run of a region is its root.
void RegionFilter::unite(int32_t a, int32_t b) {
  a = rootOf(a);
  b = rootOf(b);
  if (a == b) return;
  if (b < a) std::swap(a, b);
  runs_[b].parent = a;
  runs_[a].pixels += runs_[b].pixels;
}

}  // namespace predictive_stereo
#endif
