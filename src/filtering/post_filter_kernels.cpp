#include "filtering/post_filter_kernels.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "matching/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filtering/post_filter_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// The borders, and images that are narrower than a vector.
float filterPixelBySupport(const float* const rows[5], int x, int width, float smallest_valid,
                           float invalid, int min_support) {
  const float centre = rows[2][x];
  if (!(centre >= smallest_valid)) return invalid;
  const float lowest = std::max(centre - 1, smallest_valid), highest = centre + 1;
  int support = 0;
  for (int i = 0; i < 5; ++i)
    if (rows[i])
      for (int column = std::max(0, x - 2); column <= std::min(width - 1, x + 2); ++column)
        support += rows[i][column] >= lowest && rows[i][column] <= highest;
  return support >= min_support ? centre : invalid;
}

void filterRowBySupport(const float* const rows[5], int width, float smallest_valid, float invalid,
                        int min_support, float* filtered) {
  const hn::ScalableTag<float> d;
  const hn::RebindToSigned<decltype(d)> di;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto scalar = [&](int x) {
    filtered[x] = filterPixelBySupport(rows, x, width, smallest_valid, invalid, min_support);
  };
  if (width < lanes + 4) {
    for (int x = 0; x < width; ++x) scalar(x);
    return;
  }
  for (int x : {0, 1, width - 2, width - 1}) scalar(x);

  const auto smallest = hn::Set(d, smallest_valid), one = hn::Set(d, 1.f);
  const auto too_few = hn::Set(di, min_support - 1);
  const int last = width - 2 - lanes;  // the last vector may overlap the one before
  for (int x = 2; x < width - 2; x += lanes) {
    x = std::min(x, last);
    const auto centre = hn::LoadU(d, rows[2] + x);
    const auto lowest = hn::Max(hn::Sub(centre, one), smallest), highest = hn::Add(centre, one);
    const auto valid = hn::Ge(centre, smallest);
    auto support = hn::Zero(di);
    const auto addRow = [&](const float* row) {
      if (!row) return;
      const auto addPixel = [&](const float* neighbours) {
        const auto value = hn::LoadU(d, neighbours);
        const auto near = hn::Eq(value, hn::Max(hn::Min(value, highest), lowest));
        support = hn::Sub(support, hn::VecFromMask(di, hn::RebindMask(di, near)));
      };
      addPixel(row + x - 2);
      addPixel(row + x - 1);
      addPixel(row + x);
      addPixel(row + x + 1);
      addPixel(row + x + 2);
    };
    const auto supported = [&] {
      return hn::And(valid, hn::RebindMask(d, hn::Gt(support, too_few)));
    };
    // After three rows most pixels have support enough.
    addRow(rows[2]);
    addRow(rows[1]);
    addRow(rows[3]);
    auto kept = supported();
    if (!hn::AllTrue(d, hn::Or(kept, hn::Not(valid)))) {
      addRow(rows[0]);
      addRow(rows[4]);
      kept = supported();
    }
    hn::StoreU(hn::IfThenElse(kept, centre, hn::Set(d, invalid)), d, filtered + x);
  }
}

float medianOfPixel(const float* const rows[3], int x, int width, float smallest_valid,
                    float invalid) {
  float values[9];  // sorted
  int count = 0;
  for (int i = 0; i < 3; ++i) {
    if (!rows[i]) continue;
    for (int column = std::max(0, x - 1); column <= std::min(width - 1, x + 1); ++column) {
      const float value = rows[i][column];
      if (!(value >= smallest_valid)) continue;
      int place = count++;
      for (; place > 0 && values[place - 1] > value; --place) values[place] = values[place - 1];
      values[place] = value;
    }
  }
  if (!(rows[1][x] >= smallest_valid) && count < 5) return invalid;
  return values[(count - 1) / 2];
}

template <class V>
HWY_INLINE void sort2(V& a, V& b) {
  const V smaller = hn::Min(a, b);
  b = hn::Max(a, b);
  a = smaller;
}

// Median of nine: sort the columns; the median is that of the largest of the low row, the median
// of the middle row and the smallest of the high row.
template <class V>
HWY_INLINE V medianOfNine(V (&v)[3][3]) {
  for (int j = 0; j < 3; ++j) {
    sort2(v[0][j], v[1][j]);
    sort2(v[1][j], v[2][j]);
    sort2(v[0][j], v[1][j]);
  }
  const auto median = [](V a, V b, V c) {
    sort2(a, b);
    return hn::Max(a, hn::Min(b, c));
  };
  const V low = hn::Max(hn::Max(v[0][0], v[0][1]), v[0][2]);
  const V high = hn::Min(hn::Min(v[2][0], v[2][1]), v[2][2]);
  return median(low, median(v[1][0], v[1][1], v[1][2]), high);
}

void medianOfRow(const float* const rows[3], int width, float smallest_valid, float invalid,
                 float* filtered) {
  const hn::ScalableTag<float> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto scalar = [&](int x) {
    filtered[x] = medianOfPixel(rows, x, width, smallest_valid, invalid);
  };
  if (width < lanes + 2) {
    for (int x = 0; x < width; ++x) scalar(x);
    return;
  }
  for (int x : {0, width - 1}) scalar(x);

  using V = hn::Vec<decltype(d)>;
  const V smallest = hn::Set(d, smallest_valid), none = hn::Set(d, invalid);
  const int last = width - 1 - lanes;
  for (int x = 1; x < width - 1; x += lanes) {
    x = std::min(x, last);
    V v[3][3];
    V lowest = hn::LoadU(d, rows[1] + x);
    const auto centre_valid = hn::Ge(lowest, smallest);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        v[i][j] = rows[i] ? hn::LoadU(d, rows[i] + x + j - 1) : none;
        lowest = hn::Min(lowest, v[i][j]);
      }
    if (HWY_LIKELY(hn::AllTrue(d, hn::Ge(lowest, smallest)))) {
      hn::StoreU(medianOfNine(v), d, filtered + x);
      continue;
    }
    // Invalid neighbours become by turns smaller and larger than all others: the median of the nine
    // is then the (lower) median of the valid ones.
    V filler = hn::Set(d, -std::numeric_limits<float>::max());
    V valid_count = hn::Zero(d);
    for (auto& row : v)
      for (V& value : row) {
        const auto valid = hn::Ge(value, smallest);
        value = hn::IfThenElse(valid, value, filler);
        filler = hn::IfThenElse(valid, filler, hn::Neg(filler));
        valid_count = hn::Add(valid_count, hn::IfThenElseZero(valid, hn::Set(d, 1.f)));
      }
    const auto known = hn::Or(centre_valid, hn::Ge(valid_count, hn::Set(d, 5.f)));
    hn::StoreU(hn::IfThenElse(known, medianOfNine(v), none), d, filtered + x);
  }
}

// The first pixel from x on that is valid or, as asked, is not; `width` where there is none.
template <bool kValid>
HWY_INLINE int find(const float* row, int x, int width, float smallest_valid) {
  const hn::ScalableTag<float> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto smallest = hn::Set(d, smallest_valid);
  for (; x + lanes <= width; x += lanes) {
    const auto valid = hn::Ge(hn::LoadU(d, row + x), smallest);
    const auto place = hn::FindFirstTrue(d, kValid ? valid : hn::Not(valid));
    if (place >= 0) return x + static_cast<int>(place);
  }
  while (x < width && (row[x] >= smallest_valid) != kValid) ++x;
  return x;
}

template <class D>
HWY_INLINE int fillRun(D d, float before, float step, int first, int x, int end, float* row) {
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (; x + lanes <= end; x += lanes) {
    const auto steps = hn::Iota(d, static_cast<float>(x - first + 1));
    hn::StoreU(hn::Add(hn::Set(d, before), hn::Mul(hn::Set(d, step), steps)), d, row + x);
  }
  return x;
}

void fillHolesOfRow(int width, float smallest_valid, const HoleLimits& limits, float* row) {
  for (int end = 0;;) {  // of the last run
    const int first = find<false>(row, end, width, smallest_valid);
    end = find<true>(row, first, width, smallest_valid);
    if (end >= width) break;
    if (first == 0 || end - first > limits.max_width) continue;
    const float before = row[first - 1], after = row[end], rise = after - before;
    const auto run = static_cast<float>(end - first);
    const bool hidden = rise > limits.tolerance_px && run <= rise + limits.hidden_slack_px;
    if (std::abs(rise) > limits.tolerance_px && !hidden) continue;
    const float step = hidden ? 0.0f : rise / (run + 1);
    const int x = fillRun(hn::ScalableTag<float>(), before, step, first, first, end, row);
    fillRun(hn::FixedTag<float, 1>(), before, step, first, x, end, row);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(filterRowBySupport);
HWY_EXPORT(medianOfRow);
HWY_EXPORT(fillHolesOfRow);

void filterRowBySupport(const float* const rows[5], int width, float smallest_valid, float invalid,
                        int min_support, float* filtered) {
  HWY_DYNAMIC_DISPATCH(filterRowBySupport)
  (rows, width, smallest_valid, invalid, min_support, filtered);
}

void medianOfRow(const float* const rows[3], int width, float smallest_valid, float invalid,
                 float* filtered) {
  HWY_DYNAMIC_DISPATCH(medianOfRow)(rows, width, smallest_valid, invalid, filtered);
}

void fillHolesOfRow(int width, float smallest_valid, const HoleLimits& limits, float* row) {
  HWY_DYNAMIC_DISPATCH(fillHolesOfRow)(width, smallest_valid, limits, row);
}

}  // namespace predictive_stereo
#endif
