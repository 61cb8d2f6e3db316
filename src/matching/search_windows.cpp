#include "matching/search_windows.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>

namespace predictive_stereo {
namespace {

int narrowestWindow(int needed, int count) {
  for (const int width : {16, 32, 64})
    if (needed <= width && width < count) return width;
  return count;
}

/// The window of one run.
template <int kRun>
void planRun(const short* first, const short* last, const DisparityRange& range,
             uint8_t* window_first, uint16_t* window_width) {
  bool searched[kRun];
  int begin = range.count, end = 0;  // of the hull
  for (int i = 0; i < kRun; ++i) {
    const int pixel_begin = std::max(first[i] - range.min_disparity, 0);
    const int pixel_end = std::min(last[i] - range.min_disparity + 1, range.count);
    searched[i] = pixel_begin < pixel_end;
    begin = std::min(begin, searched[i] ? pixel_begin : begin);
    end = std::max(end, searched[i] ? pixel_end : end);
  }
  const int needed = end - begin;
  const int width = narrowestWindow(needed, range.count);
  const int centred = begin - ((width - needed) >> 1);
  const int run_first = std::max(std::min(centred, range.count - width), 0);
  for (int i = 0; i < kRun; ++i) {
    window_first[i] = static_cast<uint8_t>(searched[i] ? run_first : 0);
    window_width[i] = static_cast<uint16_t>(searched[i] ? width : 0);
  }
}

void requireSize(const char* name, const cv::Mat1s& map, cv::Size size) {
  if (map.size() == size) return;
  std::ostringstream text;
  text << name << " is " << map.cols << "x" << map.rows << ", the images are " << size.width << "x"
       << size.height << ": give one range per pixel of the left image";
  throw std::invalid_argument(text.str());
}

}  // namespace

void planSearchWindows(const SearchRanges& ranges, const DisparityRange& range, cv::Size size,
                       SearchWindows& windows) {
  requireSize("ranges.first", ranges.first, size);
  requireSize("ranges.last", ranges.last, size);
  windows.first.create(size);
  windows.width.create(size);
  cv::parallel_for_(cv::Range(0, size.height), [&](const cv::Range& rows) {
    for (int y = rows.start; y < rows.end; ++y) {
      const short* first = ranges.first[y];
      const short* last = ranges.last[y];
      uint8_t* window_first = windows.first[y];
      uint16_t* window_width = windows.width[y];
      int x = 0;
      for (; x + kWindowRun <= size.width; x += kWindowRun)
        planRun<kWindowRun>(first + x, last + x, range, window_first + x, window_width + x);
      if (x < size.width) {
        // The last run may be shorter: its other pixels are not searched.
        short run_first[kWindowRun], run_last[kWindowRun];
        uint8_t planned_first[kWindowRun];
        uint16_t planned_width[kWindowRun];
        std::fill_n(run_first, kWindowRun, short{1});
        std::fill_n(run_last, kWindowRun, short{0});
        std::copy(first + x, first + size.width, run_first);
        std::copy(last + x, last + size.width, run_last);
        planRun<kWindowRun>(run_first, run_last, range, planned_first, planned_width);
        std::copy_n(planned_first, size.width - x, window_first + x);
        std::copy_n(planned_width, size.width - x, window_width + x);
      }
    }
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

void planFullSearch(const DisparityRange& range, cv::Size size, SearchWindows& windows) {
  windows.first.create(size);
  windows.width.create(size);
  windows.first.setTo(0);
  windows.width.setTo(range.count);
}

}  // namespace predictive_stereo
