#include "detection/free_space_rows.h"

#include <algorithm>

#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detection/free_space_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "detection/row_motion-inl.h"

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

// Short loops without branches over kChunk cells at a time, see comparison_rows.cpp.
constexpr int kChunk = 64;

// What is known of a chunk of cells.
struct Cells {
  int first, count;
  const float *d, *variance, *width;
  float depth[kChunk];
  int32_t through[kChunk], same[kChunk], came_back[kChunk], through_by[kChunk];
};

// Where the cells were in a past frame.
struct Places {
  float expected[kChunk], variance[kChunk];  // disparity, and variance of its difference
  int32_t offset[kChunk], inside[kChunk];
};

HWY_INLINE void placesOf(const SightRow& row, const PastSight& past, const Cells& cells,
                         Places& places) {
  const RowMotion motion(past.H, row.y);
  const PastMap map{past.stride, past.columns, past.rows};
  const float per_step = 1 / static_cast<float>(row.lattice_step_px);
  const float per_fB = 1 / row.disparity_times_depth, per_focal = 1 / row.focal_px;
  const DepthNoiseOfRow noise = past.noise;
  constexpr float kVariances = kSightSigmas * kSightSigmas;
  constexpr float kOfMaps_px2 = kMapSigma_px * kMapSigma_px, kOfScale = kScaleSigma * kScaleSigma;
  const int step_x = row.step_x, x0 = row.first_x + step_x * cells.first;
  for (int i = 0; i < cells.count; ++i) {
    const auto x = static_cast<float>(x0 + step_x * i);
    const float d = cells.d[i];
    const float per_w = 1 / motion.w(x, d);
    const float column = motion.x(x, d) * per_w * per_step + 0.5f;
    const float line = motion.y(x, d) * per_w * per_step + 0.5f;
    const float expected = motion.d(x, d) * per_w;
    places.offset[i] = map.offset(column, line, expected > 0, places.inside[i]);
    places.expected[i] = expected;
    const float of_depth = noise.variance((x - row.cx_px) * per_focal, cells.depth[i]);
    const float by_depth = expected * expected * per_fB;
    places.variance[i] =
        kVariances * (cells.variance[i] + kOfMaps_px2 + by_depth * by_depth * of_depth +
                      kOfScale * expected * expected);
  }
}

HWY_INLINE void addSights(const PastSight& past, int number, const Places& places, Cells& cells) {
  float nearest[kChunk], farthest[kChunk];
  for (int i = 0; i < cells.count; ++i) {
    nearest[i] = past.nearest_px[places.offset[i]];
    farthest[i] = past.farthest_px[places.offset[i]];
  }
  for (int i = 0; i < cells.count; ++i) {
    const float expected = places.expected[i], variance = places.variance[i];
    const float behind = expected - nearest[i], before = farthest[i] - expected;
    const int32_t known = places.inside[i] & (nearest[i] > 0 ? 1 : 0);
    // Within what was measured around the place: the same, whatever the noise.
    const int32_t within = (before <= 0) & (behind <= 0) ? 1 : 0;
    const int32_t farther = (behind > 0) & (behind * behind > variance) ? 1 : 0;
    const int32_t not_nearer = (before < 0) | (before * before < variance) ? 1 : 0;
    const int32_t thin = cells.width[i] * expected < kThinnest_px * cells.d[i] ? 1 : 0;
    const int32_t is_through = known & (1 - within) & farther & (1 - thin);
    const int32_t is_same = known & (within | ((1 - farther) & not_nearer));
    cells.through_by[i] =
        is_through & (cells.through[i] == 0 ? 1 : 0) ? number : cells.through_by[i];
    cells.through[i] += is_through;
    cells.same[i] += is_same;
    cells.came_back[i] += is_same & (cells.through[i] > 0 ? 1 : 0);
  }
}

HWY_NOINLINE void sightsRow(const SightRow& row, const PastSight* past, int count, float least_px,
                            uint8_t* HWY_RESTRICT through_by, uint8_t* HWY_RESTRICT fixed) {
  Cells cells;
  Places places;
  for (cells.first = 0; cells.first < row.cells; cells.first += kChunk) {
    const int n = std::min(kChunk, row.cells - cells.first);
    cells.count = n;
    cells.d = row.disparity_px + cells.first;
    cells.variance = row.variance_px2 + cells.first;
    cells.width = row.width_px + cells.first;
    int32_t any = 0;
    for (int i = 0; i < n; ++i) any |= cells.d[i] >= least_px ? 1 : 0;
    if (any == 0) {
      std::fill_n(through_by + cells.first, n, uint8_t{0});
      std::fill_n(fixed + cells.first, n, uint8_t{0});
      continue;
    }
    for (int i = 0; i < n; ++i) cells.depth[i] = row.disparity_times_depth / cells.d[i];
    for (int32_t* counts : {cells.through, cells.same, cells.came_back, cells.through_by})
      std::fill_n(counts, n, 0);
    for (int k = 0; k < count; ++k) {
      placesOf(row, past[k], cells, places);
      addSights(past[k], k + 1, places, cells);
    }
    for (int i = 0; i < n; ++i) {
      const int32_t compared = cells.d[i] >= least_px ? 1 : 0;
      const int32_t enough =
          (cells.through[i] >= kFewestThrough) & (cells.through[i] > cells.came_back[i]) ? compared
                                                                                         : 0;
      through_by[cells.first + i] = static_cast<uint8_t>(enough * cells.through_by[i]);
      fixed[cells.first + i] = static_cast<uint8_t>(-(compared & (cells.same[i] > 0 ? 1 : 0)));
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(sightsRow);

void sightsRow(const SightRow& row, const PastSight* past, int count, float least_px,
               uint8_t* through_by, uint8_t* fixed) {
  HWY_DYNAMIC_DISPATCH(sightsRow)(row, past, count, least_px, through_by, fixed);
}

}  // namespace predictive_stereo
#endif
