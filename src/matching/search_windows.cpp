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
  const auto firstIndex = [&](int first) { return std::max(first - range.min_disparity, 0); };
  const auto lastIndex = [&](int last) {
    return std::min(last - range.min_disparity, range.count - 1);
  };
  cv::parallel_for_(cv::Range(0, size.height), [&](const cv::Range& rows) {
    for (int y = rows.start; y < rows.end; ++y) {
      const short* first = ranges.first[y];
      const short* last = ranges.last[y];
      for (int run = 0; run < size.width; run += kWindowRun) {
        const int run_end = std::min(run + kWindowRun, size.width);
        int needed = 0;
        for (int x = run; x < run_end; ++x)
          needed = std::max(needed, lastIndex(last[x]) - firstIndex(first[x]) + 1);
        const int width = narrowestWindow(needed, range.count);
        for (int x = run; x < run_end; ++x) {
          const int slack = width - (lastIndex(last[x]) - firstIndex(first[x]) + 1);
          const bool searched = slack < width;
          const int centred = firstIndex(first[x]) - slack / 2;
          windows.first(y, x) = searched ? std::clamp(centred, 0, range.count - width) : 0;
          windows.width(y, x) = searched ? width : 0;
        }
      }
    }
  });
}

void planFullSearch(const DisparityRange& range, cv::Size size, SearchWindows& windows) {
  windows.first.create(size);
  windows.width.create(size);
  windows.first.setTo(0);
  windows.width.setTo(range.count);
}

}  // namespace predictive_stereo
