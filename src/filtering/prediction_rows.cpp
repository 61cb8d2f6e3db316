#include "filtering/prediction_rows.h"

#include <algorithm>
#include <cmath>

#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filtering/prediction_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Warps the pixels of a row, as many at a time as D has lanes.
template <class D>
class RowWarp {
  using DI = hn::RebindToSigned<D>;
  using DU = hn::RebindToUnsigned<D>;
  using V = hn::Vec<D>;

 public:
  HWY_INLINE RowWarp(const RowMotion& motion, const WarpLimits& limits)
      : smallest_(hn::Set(d_, limits.smallest)),
        largest_(hn::Set(d_, limits.largest)),
        columns_(hn::Set(d_, static_cast<float>(limits.columns))),
        rows_(hn::Set(d_, static_cast<float>(limits.rows))),
        row_pixels_(hn::Set(di_, limits.columns)) {
    for (int i = 0; i < 4; ++i) {
      by_x_[i] = hn::Set(d_, motion.by_x[i]);
      by_d_[i] = hn::Set(d_, motion.by_d[i]);
      constant_[i] = hn::Set(d_, motion.constant[i]);
    }
  }

  // Processes pixels from x on in whole vectors; returns the first pixel that is left over.
  HWY_INLINE int run(const float* disparity_px, const float* variance_px2, int width, int x,
                     const WarpedRow& warped) {
    const int lanes = static_cast<int>(hn::Lanes(d_));
    for (; x + lanes <= width; x += lanes) {
      const V disparity = hn::LoadU(d_, disparity_px + x);
      const V position = hn::Iota(d_, static_cast<float>(x));
      const auto component = [&](int i) HWY_ATTR {
        return hn::Add(hn::Add(hn::Mul(by_x_[i], position), hn::Mul(by_d_[i], disparity)),
                       constant_[i]);
      };
      const V depth_ratio = component(3);  // Z / Z_prev: positive in front of the camera
      const V scale = hn::Div(hn::Set(d_, 1.0f), depth_ratio);
      const V half = hn::Set(d_, 0.5f), zero = hn::Zero(d_);
      const V column = hn::Add(hn::Mul(component(0), scale), half);
      const V row = hn::Add(hn::Mul(component(1), scale), half);
      const V moved = hn::Mul(component(2), scale);
      const auto in_front = hn::And(hn::Gt(depth_ratio, zero), hn::Ge(disparity, smallest_));
      const auto in_range = hn::And(hn::Ge(moved, smallest_), hn::Le(moved, largest_));
      const auto in_columns = hn::And(hn::Ge(column, zero), hn::Lt(column, columns_));
      const auto in_rows = hn::And(hn::Ge(row, zero), hn::Lt(row, rows_));
      const auto visible = hn::And(hn::And(in_front, in_range), hn::And(in_columns, in_rows));

      // For pixels outside the image the conversion is undefined; they are discarded below.
      const auto inside =
          hn::Add(hn::Mul(hn::ConvertTo(di_, row), row_pixels_), hn::ConvertTo(di_, column));
      const auto index = hn::IfThenElse(hn::RebindMask(di_, visible), inside, none_);
      hn::StoreU(index, di_, warped.target + x);
      // Phi = d_pred / d (eq. 3) is the ratio of depths, which is also defined for d = 0.
      hn::StoreU(moved, d_, warped.disparity_px + x);
      hn::StoreU(hn::Mul(hn::Mul(scale, scale), hn::LoadU(d_, variance_px2 + x)), d_,
                 warped.variance_px2 + x);
      // -1 (none) is the smallest index as a signed number, and the largest as an unsigned one.
      last_ = hn::Max(last_, index);
      first_ = hn::Min(first_, hn::BitCast(du_, index));
    }
    return x;
  }

  // First and last of all targets so far; -1: none.
  int firstTarget() const { return static_cast<int>(hn::GetLane(hn::MinOfLanes(du_, first_))); }
  int lastTarget() const { return hn::GetLane(hn::MaxOfLanes(di_, last_)); }

 private:
  const D d_{};
  const DI di_{};
  const DU du_{};
  V by_x_[4], by_d_[4], constant_[4];
  V smallest_, largest_, columns_, rows_;
  hn::Vec<DI> row_pixels_;
  hn::Vec<DI> none_ = hn::Set(di_, -1), last_ = none_;
  hn::Vec<DU> first_ = hn::BitCast(du_, none_);
};

void warpRow(const RowMotion& motion, const float* disparity_px, const float* variance_px2,
             const WarpLimits& limits, WarpedRow& warped) {
  RowWarp<hn::ScalableTag<float>> vectors(motion, limits);
  RowWarp<hn::FixedTag<float, 1>> pixels(motion, limits);
  const int x = vectors.run(disparity_px, variance_px2, limits.columns, 0, warped);
  pixels.run(disparity_px, variance_px2, limits.columns, x, warped);
  const int last = std::max(vectors.lastTarget(), pixels.lastTarget());
  const auto first = std::min(static_cast<unsigned>(vectors.firstTarget()),
                              static_cast<unsigned>(pixels.firstTarget()));
  warped.first_row = last < 0 ? limits.rows : static_cast<int>(first) / limits.columns;
  warped.last_row = last < 0 ? -1 : last / limits.columns;
}

// Processes pixels from x on in whole vectors; returns the first remaining pixel. The
// neighbours of a filled hole are known, so a filled value is never used again: the three rows may
// overlap as shifted parts of one row.
template <class D>
HWY_INLINE int fillPixels(D d, const ConstPredictionRow before, const ConstPredictionRow after,
                          int width, float smallest_valid, int x,
                          const MutablePredictionRow filled) {
  const hn::RebindToSigned<D> di;
  const hn::Rebind<uint8_t, D> d8;
  const auto smallest = hn::Set(d, smallest_valid), half = hn::Set(d, 0.5f);
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (; x + lanes <= width; x += lanes) {
    const auto d0 = hn::LoadU(d, before.disparity_px + x);
    const auto d1 = hn::LoadU(d, filled.disparity_px + x);
    const auto d2 = hn::LoadU(d, after.disparity_px + x);
    const auto fillable = hn::And(hn::Ge(d0, smallest), hn::Ge(d2, smallest));
    const auto hole = hn::And(hn::Lt(d1, smallest), fillable);
    if (hn::AllFalse(d, hole)) continue;

    const auto mean = [&](auto a, auto b) HWY_ATTR { return hn::Mul(half, hn::Add(a, b)); };
    const auto v0 = hn::LoadU(d, before.variance_px2 + x);
    const auto v1 = hn::LoadU(d, filled.variance_px2 + x);
    const auto v2 = hn::LoadU(d, after.variance_px2 + x);
    hn::StoreU(hn::IfThenElse(hole, mean(d0, d2), d1), d, filled.disparity_px + x);
    hn::StoreU(hn::IfThenElse(hole, mean(v0, v2), v1), d, filled.variance_px2 + x);
    const auto m0 = hn::LoadU(d8, before.missed_frames + x);
    const auto m1 = hn::LoadU(d8, filled.missed_frames + x);
    const auto m2 = hn::LoadU(d8, after.missed_frames + x);
    const auto hole_mask = hn::VecFromMask(di, hn::RebindMask(di, hole));
    const auto hole8 = hn::MaskFromVec(hn::DemoteTo(d8, hn::And(hole_mask, hn::Set(di, 255))));
    hn::StoreU(hn::IfThenElse(hole8, hn::Max(m0, m2), m1), d8, filled.missed_frames + x);
  }
  return x;
}

void fillBetween(const ConstPredictionRow& before, const ConstPredictionRow& after, int width,
                 float smallest_valid, const MutablePredictionRow& filled) {
  const int x =
      fillPixels(hn::ScalableTag<float>(), before, after, width, smallest_valid, 0, filled);
  fillPixels(hn::FixedTag<float, 1>(), before, after, width, smallest_valid, x, filled);
}

void markEdges(const float* HWY_RESTRICT row, const float* HWY_RESTRICT row_below, int width,
               float jump_px, float smallest_valid, uint8_t* HWY_RESTRICT edges) {
  for (int x = 0; x + 1 < width; ++x) {
    const float centre = row[x], right = row[x + 1], below = row_below[x];
    const bool jumps_right = (std::abs(centre - right) > jump_px) & (right >= smallest_valid);
    const bool jumps_down = (std::abs(centre - below) > jump_px) & (below >= smallest_valid);
    edges[x] = (centre >= smallest_valid) & (jumps_right | jumps_down) ? 255 : 0;
  }
  const float centre = row[width - 1], below = row_below[width - 1];
  edges[width - 1] =
      centre >= smallest_valid && below >= smallest_valid && std::abs(centre - below) > jump_px
          ? 255
          : 0;
}

void uniteMarks(const uint8_t* HWY_RESTRICT marks, int width, uint8_t* HWY_RESTRICT united) {
  for (int x = 0; x < width; ++x) united[x] = united[x] | marks[x];
}

void addNoiseOrReset(const RowNoise& noise, const float* HWY_RESTRICT disparity_px,
                     const uint8_t* HWY_RESTRICT near_edge, int width, float smallest_valid,
                     float reset_px2, float* HWY_RESTRICT variance_px2) {
  const RowNoise n = noise;
  for (int x = 0; x < width; ++x) {
    const float d = disparity_px[x];
    const float z = d * n.per_fb;
    const float x_n = (static_cast<float>(x) - n.centre_column) * n.per_fx;
    const float form =
        n.zz * z * z + n.yy + n.xx * x_n * x_n + n.zy * z - n.zx * z * x_n - n.yx * x_n;
    const float predicted = variance_px2[x] + n.floor_px2 + d * d * form;
    const float variance = near_edge[x] != 0 ? reset_px2 : predicted;
    variance_px2[x] = d >= smallest_valid ? variance : 0.0f;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(warpRow);
HWY_EXPORT(fillBetween);
HWY_EXPORT(markEdges);
HWY_EXPORT(uniteMarks);
HWY_EXPORT(addNoiseOrReset);

void warpRow(const RowMotion& motion, const float* disparity_px, const float* variance_px2,
             const WarpLimits& limits, WarpedRow& warped) {
  HWY_DYNAMIC_DISPATCH(warpRow)(motion, disparity_px, variance_px2, limits, warped);
}

void fillBetween(const ConstPredictionRow& before, const ConstPredictionRow& after, int width,
                 float smallest_valid, const MutablePredictionRow& filled) {
  HWY_DYNAMIC_DISPATCH(fillBetween)(before, after, width, smallest_valid, filled);
}

void markEdges(const float* row, const float* row_below, int width, float jump_px,
               float smallest_valid, uint8_t* edges) {
  HWY_DYNAMIC_DISPATCH(markEdges)(row, row_below, width, jump_px, smallest_valid, edges);
}

void uniteMarks(const uint8_t* marks, int width, uint8_t* united) {
  HWY_DYNAMIC_DISPATCH(uniteMarks)(marks, width, united);
}

void addNoiseOrReset(const RowNoise& noise, const float* disparity_px, const uint8_t* near_edge,
                     int width, float smallest_valid, float reset_px2, float* variance_px2) {
  HWY_DYNAMIC_DISPATCH(addNoiseOrReset)
  (noise, disparity_px, near_edge, width, smallest_valid, reset_px2, variance_px2);
}

}  // namespace predictive_stereo
#endif
