#include "detection/history_rows.h"

#include "matching/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detection/history_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

// Plain loops without branches over some points at a time, see comparison_rows.cpp.
constexpr int kChunk = 64;

struct Chunk {
  const float *x, *y, *d;
  int count;
};

// Disparities that points should have had then and those that were measured there; negative: none.
struct Seen {
  float expected[kChunk], measured[kChunk];
};

HWY_INLINE void look(const Chunk& points, const float* H, const PastDisparities& then,
                     float smallest, Seen& seen) {
  const float h0 = H[0], h1 = H[1], h2 = H[2], h3 = H[3], h4 = H[4], h5 = H[5], h6 = H[6],
              h7 = H[7], h8 = H[8], h9 = H[9], h10 = H[10], h11 = H[11], h12 = H[12], h13 = H[13],
              h14 = H[14], h15 = H[15];
  const auto columns = static_cast<float>(then.columns), rows = static_cast<float>(then.rows);
  const int stride = then.stride;
  const float *HWY_RESTRICT xs = points.x, *HWY_RESTRICT ys = points.y, *HWY_RESTRICT ds = points.d;
  int32_t offset[kChunk], inside[kChunk];
  for (int i = 0; i < points.count; ++i) {
    const float x = xs[i], y = ys[i], d = ds[i];
    const float w = h3 * x + h7 * y + h11 * d + h15;
    const float column = (h0 * x + h4 * y + h8 * d + h12) / w + 0.5f;
    const float line = (h1 * x + h5 * y + h9 * d + h13) / w + 0.5f;
    const float expected = (h2 * x + h6 * y + h10 * d + h14) / w;
    const bool is_inside =
        (expected > 0) & (column >= 0) & (line >= 0) & (column < columns) & (line < rows);
    const float usable_column = is_inside ? column : 0.0f, usable_line = is_inside ? line : 0.0f;
    seen.expected[i] = expected;
    inside[i] = is_inside ? 1 : 0;
    offset[i] = static_cast<int32_t>(usable_line) * stride + static_cast<int32_t>(usable_column);
  }
  for (int i = 0; i < points.count; ++i) seen.measured[i] = then.disparity_px[offset[i]];
  for (int i = 0; i < points.count; ++i) {
    const float measured = seen.measured[i];
    const bool is_known = (inside[i] != 0) & (measured >= smallest);
    seen.measured[i] = is_known ? (measured < 0 ? 0.0f : measured) : -1.0f;
  }
}

// In standard deviations; positive: something nearer was seen.
HWY_INLINE float errorOf(const CostLimits& limits, float expected, float measured) {
  return (measured - expected) / (limits.sigma_px + limits.sigma_per_disparity * expected);
}

HWY_INLINE float costOf(const CostLimits& limits, float error, bool is_seen) {
  const float square = error * error;
  const float large = error > 0 ? limits.unknown : limits.most;
  const float cost = square < limits.most ? square : large;
  return is_seen ? cost : limits.unknown;
}

HWY_INLINE Chunk chunkOf(const PointRow& points, int first) {
  return {points.x + first, points.y + first, points.d + first,
          std::min(kChunk, points.count - first)};
}

HWY_NOINLINE void costRow(const PointRow& points, const PastDisparities& then,
                          const CostLimits& of_points, float* HWY_RESTRICT cost) {
  const CostLimits limits = of_points;
  Seen seen;
  for (int first = 0; first < points.count; first += kChunk) {
    const Chunk chunk = chunkOf(points, first);
    look(chunk, then.H, then, limits.smallest_valid_px, seen);
    for (int i = 0; i < chunk.count; ++i)
      cost[first + i] = costOf(limits, errorOf(limits, seen.expected[i], seen.measured[i]),
                               seen.measured[i] >= 0);
  }
}

// What hid the place of a static point was the object itself where it has its disparity.
HWY_NOINLINE void gainRow(const PointRow& points, const float* static_H,
                          const PastDisparities& then, const CostLimits& of_points,
                          float* HWY_RESTRICT gain, uint8_t* HWY_RESTRICT known) {
  const CostLimits limits = of_points;
  Seen moved, still;
  int32_t is_known[kChunk];
  for (int first = 0; first < points.count; first += kChunk) {
    const Chunk chunk = chunkOf(points, first);
    look(chunk, then.H, then, limits.smallest_valid_px, moved);
    look(chunk, static_H, then, limits.smallest_valid_px, still);
    for (int i = 0; i < chunk.count; ++i) {
      const float by_object = costOf(limits, errorOf(limits, moved.expected[i], moved.measured[i]),
                                     moved.measured[i] >= 0);
      const float measured = still.measured[i];
      const float error = errorOf(limits, still.expected[i], measured);
      const float of_object = errorOf(limits, moved.expected[i], measured);
      const bool explained = error * error < limits.most;
      const bool hidden = (error > 0) & (of_object * of_object > limits.most);
      const bool both = (by_object != limits.unknown) & (measured >= 0) & (explained | !hidden);
      const float by_static = explained ? error * error : limits.most;
      gain[first + i] = both ? by_static - by_object : 0.0f;
      is_known[i] = both ? 1 : 0;
    }
    for (int i = 0; i < chunk.count; ++i) known[first + i] = static_cast<uint8_t>(is_known[i]);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(costRow);
HWY_EXPORT(gainRow);

void costRow(const PointRow& points, const PastDisparities& then, const CostLimits& limits,
             float* cost) {
  HWY_DYNAMIC_DISPATCH(costRow)(points, then, limits, cost);
}

void gainRow(const PointRow& points, const float* static_H, const PastDisparities& then,
             const CostLimits& limits, float* gain, uint8_t* known) {
  HWY_DYNAMIC_DISPATCH(gainRow)(points, static_H, then, limits, gain, known);
}

}  // namespace predictive_stereo
#endif
