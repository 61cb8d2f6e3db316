#include "predictive_stereo/region_filter.h"

#include <algorithm>
#include <cstring>

#include "filtering/connection_rows.h"
#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

constexpr int kBandRows = 32;

}  // namespace

void RegionFilter::filter(const DisparityRange& range, int min_region_px, cv::Mat1f& disparity_px) {
  if (min_region_px <= 1 || disparity_px.empty()) return;
  const int width = disparity_px.cols, height = disparity_px.rows;
  findRuns(disparity_px, static_cast<float>(range.min_disparity));
  // First within bands, which are independent, then across their borders. The order of unions does
  // not depend on the number of threads.
  const int bands = (height + kBandRows - 1) / kBandRows;
  parallelFor(cv::Range(0, bands), [&](const cv::Range& part) {
    for (int band = part.start; band < part.end; ++band)
      for (int y = band * kBandRows + 1; y < std::min((band + 1) * kBandRows, height); ++y)
        connectRows(y);
  });
  for (int y = kBandRows; y < height; y += kBandRows) connectRows(y);
  // Parents come before their runs, so after this loop the parent of each run is its root.
  for (int y = 0; y < height; ++y)
    for (int32_t run = y * width; run < y * width + run_count_[y]; ++run)
      runs_[run].parent = runs_[runs_[run].parent].parent;
  parallelFor(cv::Range(0, height), [&](const cv::Range& rows) {
    for (int y = rows.start; y < rows.end; ++y)
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
  parallelFor(cv::Range(0, height), [&](const cv::Range& rows) {
    for (int y = rows.start; y < rows.end; ++y) {
      const float* const row = disparity_px[y];
      uint8_t* const across = across_[y];
      connectionsOfRow(row, row + 1, width - 1, smallest_valid, across);
      across[width - 1] = 0;
      if (y + 1 < height)
        connectionsOfRow(row, disparity_px[y + 1], width, smallest_valid, down_[y]);
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
    }
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
