#include "detection/suspicion_rows.h"

#include <algorithm>

#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detection/suspicion_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

constexpr int kChunk = 128;
constexpr int kSquare = kTextureSide * kTextureSide;
static_assert(kTextureSide == 5, "sums are written out, and fit into 16 bits");

HWY_NOINLINE void greyDeviationRow(const uint8_t* const rows[kTextureSide], int width,
                                   uint16_t* HWY_RESTRICT deviation) {
  const int edge = std::min(kTextureReach, width);
  std::fill_n(deviation, edge, uint16_t{0});
  std::fill_n(deviation + width - edge, edge, uint16_t{0});
  int16_t columns[kChunk + 2 * kTextureReach];
  for (int u = kTextureReach; u < width - kTextureReach; u += kChunk) {
    const int n = std::min(kChunk, width - kTextureReach - u);
    const uint8_t *r0 = rows[0] + u - kTextureReach, *r1 = rows[1] + u - kTextureReach,
                  *r2 = rows[2] + u - kTextureReach, *r3 = rows[3] + u - kTextureReach,
                  *r4 = rows[4] + u - kTextureReach;
    for (int i = 0; i < n + 2 * kTextureReach; ++i)
      columns[i] = static_cast<int16_t>(r0[i] + r1[i] + r2[i] + r3[i] + r4[i]);
    for (int i = 0; i < n; ++i) {
      const auto sum = static_cast<int16_t>(columns[i] + columns[i + 1] + columns[i + 2] +
                                            columns[i + 3] + columns[i + 4]);
      const auto scaled = static_cast<int16_t>(kSquare * r2[i + kTextureReach]);
      deviation[u + i] = static_cast<uint16_t>(std::max(scaled, sum) - std::min(scaled, sum));
    }
  }
}

HWY_NOINLINE void suspicionRow(const uint16_t* const deviations[kTextureSide],
                               const float* HWY_RESTRICT mismatch, int width, float noise,
                               float* HWY_RESTRICT suspicion) {
  const int edge = std::min(kTextureReach, width);
  std::fill_n(suspicion, edge, 0.0f);
  std::fill_n(suspicion + width - edge, edge, 0.0f);
  int32_t columns[kChunk + 2 * kTextureReach];
  for (int u = kTextureReach; u < width - kTextureReach; u += kChunk) {
    const int n = std::min(kChunk, width - kTextureReach - u);
    const uint16_t *r0 = deviations[0] + u - kTextureReach, *r1 = deviations[1] + u - kTextureReach,
                   *r2 = deviations[2] + u - kTextureReach, *r3 = deviations[3] + u - kTextureReach,
                   *r4 = deviations[4] + u - kTextureReach;
    for (int i = 0; i < n + 2 * kTextureReach; ++i)
      columns[i] = static_cast<uint16_t>(r0[i] + r1[i] + r2[i] + r3[i] + r4[i]);
    for (int i = 0; i < n; ++i) {
      const int32_t sum =
          columns[i] + columns[i + 1] + columns[i + 2] + columns[i + 3] + columns[i + 4];
      const float texture = static_cast<float>(sum) / (kSquare * kSquare);
      const float m = mismatch[u + i];
      suspicion[u + i] = m >= 0 ? m / (texture + noise) : 0.0f;
    }
  }
}

// The first maximum of a cell, without branches, which would be unpredictable.
HWY_INLINE int32_t placeOfLargest(const float* const rows[kCell], int first) {
  float largest = rows[0][first];
  for (int k = 0; k < kCell; ++k)
    for (int i = 0; i < kCell; ++i) largest = std::max(largest, rows[k][first + i]);
  uint32_t places = 0;
  for (int k = 0; k < kCell; ++k)
    for (int i = 0; i < kCell; ++i)
      places |= (rows[k][first + i] == largest ? 1u : 0u) << (kCell * k + i);
  return static_cast<int32_t>(hwy::Num0BitsBelowLS1Bit_Nonzero32(places));
}

HWY_NOINLINE int suspiciousCells(const float* const rows[kCell], int cells, float least,
                                 int32_t* HWY_RESTRICT found, int32_t* HWY_RESTRICT worst) {
  static_assert(kCell == 4, "written out");
  int count = 0;
  float largest[kChunk];
  for (int first = 0; first < cells; first += kChunk / kCell) {
    const int n = std::min(kChunk / kCell, cells - first);
    const float *r0 = rows[0] + kCell * first, *r1 = rows[1] + kCell * first,
                *r2 = rows[2] + kCell * first, *r3 = rows[3] + kCell * first;
    for (int i = 0; i < kCell * n; ++i) {
      const float upper = r0[i] > r1[i] ? r0[i] : r1[i], lower = r2[i] > r3[i] ? r2[i] : r3[i];
      largest[i] = upper > lower ? upper : lower;
    }
    for (int c = 0; c < n; ++c) {
      const float* of_cell = largest + kCell * c;
      found[count] = first + c;
      count += (of_cell[0] >= least) | (of_cell[1] >= least) | (of_cell[2] >= least) |
               (of_cell[3] >= least);
    }
  }
  for (int k = 0; k < count; ++k) worst[k] = placeOfLargest(rows, kCell * found[k]);
  return count;
}

}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(greyDeviationRow);
HWY_EXPORT(suspicionRow);
HWY_EXPORT(suspiciousCells);

void greyDeviationRow(const uint8_t* const rows[kTextureSide], int width, uint16_t* deviation) {
  HWY_DYNAMIC_DISPATCH(greyDeviationRow)(rows, width, deviation);
}

void suspicionRow(const uint16_t* const deviations[kTextureSide], const float* mismatch, int width,
                  float noise, float* suspicion) {
  HWY_DYNAMIC_DISPATCH(suspicionRow)(deviations, mismatch, width, noise, suspicion);
}

int suspiciousCells(const float* const rows[kCell], int cells, float least, int32_t* found,
                    int32_t* worst) {
  return HWY_DYNAMIC_DISPATCH(suspiciousCells)(rows, cells, least, found, worst);
}

}  // namespace predictive_stereo
#endif
