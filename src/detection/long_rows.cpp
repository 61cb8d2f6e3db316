#include "detection/long_rows.h"

#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detection/long_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "detection/row_motion-inl.h"

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

// Short loops without branches over kChunk points at a time, see comparison_rows.cpp.
constexpr int kChunk = 64;

struct Points {
  int first, count;
  float d[kChunk];
};

struct Residuals {
  float value[kChunk];
  int32_t known[kChunk];
};

// Past disparities of static points minus measured ones.
HWY_INLINE void residualsAtPast(const LongRow& row, const PastDisparities& then,
                                const Points& points, Residuals& residuals) {
  const RowMotion motion(then.H, row.y);
  const PastMap map{then.stride, then.columns, then.rows};
  const float smallest = row.smallest_valid_px;
  const int x0 = kLongStep_px * points.first;
  float expected[kChunk], measured[kChunk];
  int32_t offset[kChunk], inside[kChunk];
  for (int i = 0; i < points.count; ++i) {
    const auto x = static_cast<float>(x0 + kLongStep_px * i);
    const float d = points.d[i];
    const float w = motion.w(x, d);
    const float column = motion.x(x, d) / w + 0.5f, line = motion.y(x, d) / w + 0.5f;
    expected[i] = motion.d(x, d) / w;
    offset[i] = map.offset(column, line, expected[i] > 0, inside[i]);
  }
  for (int i = 0; i < points.count; ++i) measured[i] = then.disparity_px[offset[i]];
  for (int i = 0; i < points.count; ++i) {
    const float residual = expected[i] - measured[i];
    residuals.value[i] = std::min(std::max(residual, -kLargestResidual_px), kLargestResidual_px);
    residuals.known[i] = ((inside[i] != 0) & (measured[i] >= smallest)) ? 1 : 0;
  }
}

// The first pair with little enough parallax, for each point; -1: none.
HWY_INLINE void choosePairs(const LongRow& row, const Points& points, int32_t* HWY_RESTRICT pair) {
  const auto y = static_cast<float>(row.y);
  const float most = row.most_parallax_px, smallest = row.smallest_valid_px;
  const int x0 = kLongStep_px * points.first;
  for (int i = 0; i < points.count; ++i) pair[i] = -1;
  for (int k = row.pair_count - 1; k >= 0; --k) {
    const PastCamera camera = row.pairs[k].camera;
    for (int i = 0; i < points.count; ++i) {
      const float d = points.d[i];
      const float moved = camera.parallax(static_cast<float>(x0 + kLongStep_px * i), y, d);
      pair[i] = ((moved <= most) & (d >= smallest)) ? k : pair[i];
    }
  }
}

HWY_NOINLINE void longResidualRow(const LongRow& row, float* HWY_RESTRICT residual_px,
                                  uint8_t* HWY_RESTRICT pair) {
  Points points;
  Residuals far, near;
  int32_t chosen[kChunk];
  for (points.first = 0; points.first < row.points; points.first += kChunk) {
    points.count = std::min(kChunk, row.points - points.first);
    const float* HWY_RESTRICT disparity = row.disparity_px + kLongStep_px * points.first;
    float* HWY_RESTRICT out = residual_px + points.first;
    for (int i = 0; i < points.count; ++i) {
      points.d[i] = disparity[kLongStep_px * i];
      out[i] = kUnknownResidual;
    }
    choosePairs(row, points, chosen);
    for (int k = 0; k < row.pair_count; ++k) {
      int32_t any = 0;
      for (int i = 0; i < points.count; ++i) any |= chosen[i] == k ? 1 : 0;
      if (any == 0) continue;
      const PastPairOfRow& of_row = row.pairs[k];
      residualsAtPast(row, of_row.past, points, far);
      residualsAtPast(row, of_row.halfway, points, near);
      const float scale = of_row.scale;
      for (int i = 0; i < points.count; ++i) {
        const float f = far.value[i], n = near.value[i] * scale;
        const float smaller = std::abs(n) < std::abs(f) ? n : f;
        const float both = n * f <= 0 ? 0.0f : smaller;
        out[i] = ((chosen[i] == k) & (far.known[i] != 0) & (near.known[i] != 0)) ? both : out[i];
      }
    }
    for (int i = 0; i < points.count; ++i)
      pair[points.first + i] = chosen[i] < 0 ? kNoPair : static_cast<uint8_t>(chosen[i]);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(longResidualRow);

void longResidualRow(const LongRow& row, float* residual_px, uint8_t* pair) {
  HWY_DYNAMIC_DISPATCH(longResidualRow)(row, residual_px, pair);
}

}  // namespace predictive_stereo
#endif
