#include "filtering/prediction_rows.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filtering/prediction_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// The pixels x, x + 1, ... of a row, as many as `d` has lanes.
template <class D>
void warpPixels(D d, const RowMotion& motion, const float* disparity_px, const float* variance_px2,
                const WarpLimits& limits, int x, WarpedRow& warped) {
  const hn::RebindToSigned<D> di;
  const auto zero = hn::Zero(d), half = hn::Set(d, 0.5f);
  const auto smallest = hn::Set(d, limits.smallest), largest = hn::Set(d, limits.largest);
  const auto columns = hn::Set(d, static_cast<float>(limits.columns));
  const auto rows = hn::Set(d, static_cast<float>(limits.rows));
  const auto disparity = hn::LoadU(d, disparity_px + x);
  const auto position = hn::Iota(d, static_cast<float>(x));
  const auto component = [&](int i) {
    return hn::Add(hn::Add(hn::Mul(hn::Set(d, motion.by_x[i]), position),
                           hn::Mul(hn::Set(d, motion.by_d[i]), disparity)),
                   hn::Set(d, motion.constant[i]));
  };
  const auto depth_ratio = component(3);  // Z / Z_prev: positive in front of the camera
  const auto scale = hn::Div(hn::Set(d, 1.0f), depth_ratio);
  const auto column = hn::Add(hn::Mul(component(0), scale), half);
  const auto row = hn::Add(hn::Mul(component(1), scale), half);
  const auto moved = hn::Mul(component(2), scale);
  const auto within = [](auto value, auto low, auto end) {
    return hn::And(hn::Ge(value, low), hn::Lt(value, end));
  };
  const auto in_front = hn::And(hn::Gt(depth_ratio, zero), hn::Ge(disparity, smallest));
  const auto in_range = hn::And(hn::Ge(moved, smallest), hn::Le(moved, largest));
  const auto in_image = hn::And(within(column, zero, columns), within(row, zero, rows));
  const auto visible = hn::And(hn::And(in_front, in_range), in_image);

  const auto visible_int = hn::RebindMask(di, visible);
  const auto target_row = hn::ConvertTo(di, hn::IfThenElseZero(visible, row));
  const auto target_column = hn::ConvertTo(di, hn::IfThenElseZero(visible, column));
  const auto index = hn::Add(hn::Mul(target_row, hn::Set(di, limits.columns)), target_column);
  hn::StoreU(hn::IfThenElse(visible_int, index, hn::Set(di, -1)), di, warped.target + x);
  // Phi = d_pred / d (eq. 3) is the ratio of depths, which also exists where d = 0.
  hn::StoreU(moved, d, warped.disparity_px + x);
  hn::StoreU(hn::Mul(hn::Mul(scale, scale), hn::LoadU(d, variance_px2 + x)), d,
             warped.variance_px2 + x);

  const auto first = hn::IfThenElse(visible_int, target_row, hn::Set(di, limits.rows));
  const auto last = hn::IfThenElse(visible_int, target_row, hn::Set(di, -1));
  warped.first_row = std::min(warped.first_row, hn::GetLane(hn::MinOfLanes(di, first)));
  warped.last_row = std::max(warped.last_row, hn::GetLane(hn::MaxOfLanes(di, last)));
}

void warpRow(const RowMotion& motion, const float* disparity_px, const float* variance_px2,
             const WarpLimits& limits, WarpedRow& warped) {
  const hn::ScalableTag<float> vectors;
  const int lanes = static_cast<int>(hn::Lanes(vectors));
  warped.first_row = limits.rows;
  warped.last_row = -1;
  int x = 0;
  for (; x + lanes <= limits.columns; x += lanes)
    warpPixels(vectors, motion, disparity_px, variance_px2, limits, x, warped);
  for (; x < limits.columns; ++x)
    warpPixels(hn::CappedTag<float, 1>(), motion, disparity_px, variance_px2, limits, x, warped);
}

template <class D>
void fillPixels(D d, const ConstPredictionRow& before, const ConstPredictionRow& centre,
                const ConstPredictionRow& after, int x, float smallest_valid,
                const MutablePredictionRow& filled) {
  const auto smallest = hn::Set(d, smallest_valid), half = hn::Set(d, 0.5f);
  const auto d0 = hn::LoadU(d, before.disparity_px + x);
  const auto d1 = hn::LoadU(d, centre.disparity_px + x);
  const auto d2 = hn::LoadU(d, after.disparity_px + x);
  const auto fillable = hn::And(hn::Ge(d0, smallest), hn::Ge(d2, smallest));
  const auto hole = hn::And(hn::Lt(d1, smallest), fillable);
  const auto mean = [&](auto a, auto b) { return hn::Mul(half, hn::Add(a, b)); };
  hn::StoreU(hn::IfThenElse(hole, mean(d0, d2), d1), d, filled.disparity_px + x);
  const auto v0 = hn::LoadU(d, before.variance_px2 + x);
  const auto v1 = hn::LoadU(d, centre.variance_px2 + x);
  const auto v2 = hn::LoadU(d, after.variance_px2 + x);
  hn::StoreU(hn::IfThenElse(hole, mean(v0, v2), v1), d, filled.variance_px2 + x);
}

// The longer absence of both neighbours; what it is where nothing is known does not matter.
HWY_NOINLINE void fillMissedFrames(const float* HWY_RESTRICT disparity_px,
                                   const uint8_t* HWY_RESTRICT before,
                                   const uint8_t* HWY_RESTRICT centre,
                                   const uint8_t* HWY_RESTRICT after, int width,
                                   float smallest_valid, uint8_t* HWY_RESTRICT filled) {
  for (int x = 0; x < width; ++x) {
    const uint8_t around = before[x] > after[x] ? before[x] : after[x];
    const uint8_t unknown = disparity_px[x] < smallest_valid ? 255 : 0;
    filled[x] = static_cast<uint8_t>((around & unknown) | (centre[x] & ~unknown));
  }
}

void fillBetween(const ConstPredictionRow& before, const ConstPredictionRow& centre,
                 const ConstPredictionRow& after, int width, float smallest_valid,
                 const MutablePredictionRow& filled) {
  const hn::ScalableTag<float> vectors;
  const int lanes = static_cast<int>(hn::Lanes(vectors));
  int x = 0;
  for (; x + lanes <= width; x += lanes)
    fillPixels(vectors, before, centre, after, x, smallest_valid, filled);
  for (; x < width; ++x)
    fillPixels(hn::CappedTag<float, 1>(), before, centre, after, x, smallest_valid, filled);

  fillMissedFrames(centre.disparity_px, before.missed_frames, centre.missed_frames,
                   after.missed_frames, width, smallest_valid, filled.missed_frames);
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
HWY_EXPORT(addNoiseOrReset);

void warpRow(const RowMotion& motion, const float* disparity_px, const float* variance_px2,
             const WarpLimits& limits, WarpedRow& warped) {
  HWY_DYNAMIC_DISPATCH(warpRow)(motion, disparity_px, variance_px2, limits, warped);
}

void fillBetween(const ConstPredictionRow& before, const ConstPredictionRow& centre,
                 const ConstPredictionRow& after, int width, float smallest_valid,
                 const MutablePredictionRow& filled) {
  HWY_DYNAMIC_DISPATCH(fillBetween)(before, centre, after, width, smallest_valid, filled);
}

void markEdges(const float* row, const float* row_below, int width, float jump_px,
               float smallest_valid, uint8_t* edges) {
  HWY_DYNAMIC_DISPATCH(markEdges)(row, row_below, width, jump_px, smallest_valid, edges);
}

void addNoiseOrReset(const RowNoise& noise, const float* disparity_px, const uint8_t* near_edge,
                     int width, float smallest_valid, float reset_px2, float* variance_px2) {
  HWY_DYNAMIC_DISPATCH(addNoiseOrReset)
  (noise, disparity_px, near_edge, width, smallest_valid, reset_px2, variance_px2);
}

}  // namespace predictive_stereo
#endif
