#include "matching/search_windows.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <sstream>
#include <stdexcept>

#include "matching/search_windows_kernel.h"
#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

void requireSize(const char* name, const cv::Mat1s& map, cv::Size size) {
  if (map.size() == size) return;
  std::ostringstream text;
  text << name << " is " << map.cols << "x" << map.rows << ", the images are " << size.width << "x"
       << size.height << ": give one range per pixel of the left image";
  throw std::invalid_argument(text.str());
}

/// The last disparity to search; see `between`. Empty ranges stay empty.
short lastOf(const SearchRanges& ranges, bool between, int y, int x) {
  const short first = ranges.first(y, x), last = ranges.last(y, x);
  const bool one_more = between && first <= last && last < std::numeric_limits<short>::max();
  return static_cast<short>(last + one_more);
}

/// Allocates the windows of an image, calls plan_row for each row, and sets positions in memory.
template <class PlanRow>
void planRows(cv::Size size, int run_length, SearchWindows& windows, const PlanRow& plan_row) {
  windows.run_length = run_length;
  windows.runs_per_row = (size.width + run_length - 1) / run_length;
  windows.runs.resize(static_cast<size_t>(size.height) * windows.runs_per_row);
  windows.width.create(size);
  windows.row_begins.assign(size.height + 1, 0);
  parallelForEach(size.height, [&](int y) {
    WindowRun* const runs = windows.row(y);
    plan_row(y, runs, windows.width[y]);
    int position = 0;
    for (int i = 0; i < windows.runs_per_row; ++i) {
      runs[i].position = position;
      position += run_length * runs[i].width;
    }
    windows.row_begins[y + 1] = position;
  });
  std::partial_sum(windows.row_begins.begin(), windows.row_begins.end(),
                   windows.row_begins.begin());
}

}  // namespace

void planSearchWindows(const SearchRanges& ranges, const DisparityRange& range, bool between,
                       cv::Size size, int64_t simd_target, SearchWindows& windows) {
  requireSize("ranges.first", ranges.first, size);
  requireSize("ranges.last", ranges.last, size);
  const PlanRowFunction plan = planRow(simd_target);
  planRows(size, kWindowRun, windows, [&](int y, WindowRun* runs, uint16_t* width) {
    const short* last = ranges.last[y];
    cv::AutoBuffer<short> behind_last(between ? size.width : 0);
    if (between) {
      for (int x = 0; x < size.width; ++x) behind_last[x] = lastOf(ranges, between, y, x);
      last = behind_last.data();
    }
    plan(ranges.first[y], last, size.width, range, runs, width);
  });
}

void planExactWindows(const SearchRanges& ranges, const DisparityRange& range, bool between,
                      cv::Size size, SearchWindows& windows) {
  requireSize("ranges.first", ranges.first, size);
  requireSize("ranges.last", ranges.last, size);
  planRows(size, 1, windows, [&](int y, WindowRun* runs, uint16_t* width) {
    for (int x = 0; x < size.width; ++x) {
      const int first = std::max<int>(ranges.first(y, x) - range.min_disparity, 0);
      const int last =
          std::min<int>(lastOf(ranges, between, y, x) - range.min_disparity, range.count - 1);
      width[x] = static_cast<uint16_t>(std::max(last - first + 1, 0));
      runs[x] = {0, width[x], static_cast<uint8_t>(width[x] > 0 ? first : 0)};
    }
  });
}

void planFullSearch(const DisparityRange& range, cv::Size size, SearchWindows& windows) {
  const auto count = static_cast<uint16_t>(range.count);
  planRows(size, kWindowRun, windows, [&](int, WindowRun* runs, uint16_t* width) {
    std::fill_n(runs, windows.runs_per_row, WindowRun{0, count, 0});
    std::fill_n(width, size.width, count);
  });
}

bool isFullSearch(const SearchWindows& windows, const DisparityRange& range) {
  for (int y = 0; y < windows.width.rows; ++y) {
    const uint16_t* const width = windows.width[y];
    const auto whole = [&](uint16_t value) { return value == range.count; };
    if (!std::all_of(width, width + windows.width.cols, whole)) return false;
  }
  return true;
}

}  // namespace predictive_stereo
