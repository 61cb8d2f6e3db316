#include "matching/search_windows.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "imaging/size_check.h"
#include "parallel/tasks.h"
#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/search_windows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

PREDICTIVE_STEREO_BEGIN_KERNELS;

#if PREDICTIVE_STEREO_HAS_VECTORS

using Shorts = hn::ScalableTag<int16_t>;
using Words = hn::RebindToUnsigned<Shorts>;

/// The windows of as many runs as a vector has lanes.
struct PlannedRuns {
  HWY_INLINE PlannedRuns() {}  // explicit: g++ would compile an implicit one for another target
  hn::Vec<Shorts> first;
  hn::Vec<Words> width;
  hn::Vec<Words> pixel_width[kWindowRun];
};

HWY_INLINE PlannedRuns planRuns(const short* first, const short* last,
                                const DisparityRange& range) {
  const Shorts d;
  const auto set = [d](int value) HWY_ATTR { return hn::Set(d, static_cast<int16_t>(value)); };
  const auto zero = hn::Zero(d), count = set(range.count), minimum = set(range.min_disparity);
  hn::Vec<Shorts> firsts[kWindowRun], lasts[kWindowRun];
  hn::LoadInterleaved4(d, first, firsts[0], firsts[1], firsts[2], firsts[3]);
  hn::LoadInterleaved4(d, last, lasts[0], lasts[1], lasts[2], lasts[3]);

  auto begin = count, end = zero;  // of the hull
  hn::Vec<Shorts> searched[kWindowRun];
  for (int k = 0; k < kWindowRun; ++k) {
    const auto pixel_begin = hn::Max(hn::SaturatedSub(firsts[k], minimum), zero);
    const auto pixel_end =
        hn::Min(hn::SaturatedAdd(hn::SaturatedSub(lasts[k], minimum), set(1)), count);
    const auto is_searched = hn::Lt(pixel_begin, pixel_end);
    searched[k] = hn::VecFromMask(d, is_searched);
    begin = hn::IfThenElse(is_searched, hn::Min(begin, pixel_begin), begin);
    end = hn::IfThenElse(is_searched, hn::Max(end, pixel_end), end);
  }
  const auto needed = hn::Sub(end, begin);
  auto width = count;
  for (const int narrower : {64, 32, 16})
    if (narrower < range.count)
      width = hn::IfThenElse(hn::Gt(needed, set(narrower)), width, set(narrower));
  const auto centred = hn::Sub(begin, hn::ShiftRight<1>(hn::Sub(width, needed)));
  const auto any = hn::Lt(begin, end);
  PlannedRuns runs;
  runs.first = hn::IfThenElseZero(any, hn::Max(hn::Min(centred, hn::Sub(count, width)), zero));
  runs.width = hn::BitCast(Words(), hn::IfThenElseZero(any, width));
  for (int k = 0; k < kWindowRun; ++k)
    runs.pixel_width[k] = hn::BitCast(Words(), hn::And(searched[k], width));
  return runs;
}

void PlanRow(const short* first, const short* last, int columns, const DisparityRange& range,
             WindowRun* runs, uint16_t* pixel_width) {
  static_assert(kWindowRun == 4);
  constexpr int kRuns = hn::MaxLanes(Shorts()), kColumns = kRuns * kWindowRun;
  HWY_ALIGN int16_t run_first[kRuns];
  HWY_ALIGN uint16_t run_width[kRuns];
  int x = 0;
  for (; x + kColumns <= columns; x += kColumns) {
    const PlannedRuns planned = planRuns(first + x, last + x, range);
    hn::StoreInterleaved4(planned.pixel_width[0], planned.pixel_width[1], planned.pixel_width[2],
                          planned.pixel_width[3], Words(), pixel_width + x);
    hn::Store(planned.first, Shorts(), run_first);
    hn::Store(planned.width, Words(), run_width);
    for (int i = 0; i < kRuns; ++i)
      runs[x / kWindowRun + i] = {0, run_width[i], static_cast<uint8_t>(run_first[i])};
  }
  planRowReference(first + x, last + x, columns - x, range, runs + x / kWindowRun, pixel_width + x);
}

#else
void PlanRow(const short*, const short*, int, const DisparityRange&, WindowRun*, uint16_t*) {}
#endif

PREDICTIVE_STEREO_END_KERNELS;

#if HWY_ONCE
namespace predictive_stereo {
namespace {

HWY_EXPORT(PlanRow);

int narrowestWindow(int needed, int count) {
  for (const int width : {16, 32, 64})
    if (needed <= width && width < count) return width;
  return count;
}

void requireOnePerPixel(const SearchRanges& ranges, cv::Size size) {
  constexpr char kExpected[] = "but give one range per pixel of the left image, which is";
  requireSize("ranges.first", ranges.first.size(), size, kExpected);
  requireSize("ranges.last", ranges.last.size(), size, kExpected);
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

void planRowReference(const short* first, const short* last, int columns,
                      const DisparityRange& range, WindowRun* runs, uint16_t* pixel_width) {
  for (int x = 0; x < columns; x += kWindowRun) {
    const int pixels = std::min(kWindowRun, columns - x);
    bool searched[kWindowRun];
    int begin = range.count, end = 0;  // of the hull
    for (int k = 0; k < pixels; ++k) {
      const int pixel_begin = std::max(first[x + k] - range.min_disparity, 0);
      const int pixel_end = std::min(last[x + k] - range.min_disparity + 1, range.count);
      searched[k] = pixel_begin < pixel_end;
      if (!searched[k]) continue;
      begin = std::min(begin, pixel_begin);
      end = std::max(end, pixel_end);
    }
    const bool any = begin < end;
    const int needed = end - begin;
    const int width = any ? narrowestWindow(needed, range.count) : 0;
    const int centred = begin - ((width - needed) >> 1);
    const int run_first = any ? std::max(std::min(centred, range.count - width), 0) : 0;
    runs[x / kWindowRun] = {0, static_cast<uint16_t>(width), static_cast<uint8_t>(run_first)};
    for (int k = 0; k < pixels; ++k)
      pixel_width[x + k] = static_cast<uint16_t>(searched[k] ? width : 0);
  }
}

PlanRowFunction planRow(int64_t simd_target) {
  return simd_target == kScalarTarget ? planRowReference
                                      : PREDICTIVE_STEREO_DISPATCH(PlanRow, simd_target);
}

void planSearchWindows(const SearchRanges& ranges, const DisparityRange& range, bool between,
                       cv::Size size, int64_t simd_target, SearchWindows& windows) {
  requireOnePerPixel(ranges, size);
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
  requireOnePerPixel(ranges, size);
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
#endif
