#include "predictive_stereo/prediction.h"

#include <algorithm>
#include <iterator>

#include "parallel/tasks.h"
#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filtering/prediction.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "simd/pixel_loop-inl.h"

#ifndef PREDICTIVE_STEREO_PREDICTION_ROWS
#define PREDICTIVE_STEREO_PREDICTION_ROWS
namespace predictive_stereo {

/// H of eq. 2 for the pixels of one row: component i of H (x, y, d, 1) is by_x[i] x + by_d[i] d +
/// constant[i].
struct RowMotion {
  float by_x[4], by_d[4], constant[4];
};

struct WarpLimits {
  int columns, rows;        ///< size of the image [px]
  float smallest, largest;  ///< disparities that are kept [px]
};

/// Where the pixels of a row are warped to.
struct WarpedRow {
  int32_t* target;          ///< index of the pixel in the current frame; -1: outside
  float* disparity_px;      ///< in the current frame
  float* variance_px2;      ///< in the current frame: Phi^2 p
  int first_row, last_row;  ///< of the targets; first_row > last_row: none
};
/// One row of a prediction.
struct PredictionRow {
  float* disparity_px;
  float* variance_px2;
  uint8_t* missed_frames;
};

}  // namespace predictive_stereo
#endif

PREDICTIVE_STEREO_BEGIN_KERNELS;

void warpRow(const RowMotion& motion, const float* disparity_px, const float* variance_px2,
             const WarpLimits& limits, WarpedRow& warped) {
  // First and last target of each lane. -1 (none) is the smallest index as a signed number, and the
  // largest as an unsigned one.
  HWY_ALIGN uint32_t firsts[hn::MaxLanes(hn::ScalableTag<uint32_t>())];
  HWY_ALIGN int32_t lasts[hn::MaxLanes(hn::ScalableTag<int32_t>())];
  std::fill(std::begin(firsts), std::end(firsts), UINT32_MAX);
  std::fill(std::begin(lasts), std::end(lasts), -1);
  uint32_t* const first_targets = firsts;
  int32_t* const last_targets = lasts;
  forPixels<float>(0, limits.columns, [=](auto d, int x) HWY_ATTR {
    const hn::RebindToSigned<decltype(d)> di;
    const hn::RebindToUnsigned<decltype(d)> du;
    const auto disparity = hn::LoadU(d, disparity_px + x);
    const auto position = hn::Iota(d, static_cast<float>(x));
    const auto component = [&](int i) HWY_ATTR {
      return hn::Add(hn::Add(hn::Mul(hn::Set(d, motion.by_x[i]), position),
                             hn::Mul(hn::Set(d, motion.by_d[i]), disparity)),
                     hn::Set(d, motion.constant[i]));
    };
    const auto depth_ratio = component(3);  // Z / Z_prev: positive in front of the camera
    const auto scale = hn::Div(hn::Set(d, 1.0f), depth_ratio);
    const auto half = hn::Set(d, 0.5f), zero = hn::Zero(d), smallest = hn::Set(d, limits.smallest);
    const auto column = hn::Add(hn::Mul(component(0), scale), half);
    const auto row = hn::Add(hn::Mul(component(1), scale), half);
    const auto moved = hn::Mul(component(2), scale);
    const auto within = [&](auto value, auto end) HWY_ATTR {
      return hn::And(hn::Ge(value, zero), hn::Lt(value, hn::Set(d, static_cast<float>(end))));
    };
    const auto in_front = hn::And(hn::Gt(depth_ratio, zero), hn::Ge(disparity, smallest));
    const auto in_range =
        hn::And(hn::Ge(moved, smallest), hn::Le(moved, hn::Set(d, limits.largest)));
    const auto in_image = hn::And(within(column, limits.columns), within(row, limits.rows));
    const auto visible = hn::And(hn::And(in_front, in_range), in_image);

    // For pixels outside the image the conversion is undefined; they are discarded below.
    const auto inside = hn::Add(hn::Mul(hn::ConvertTo(di, row), hn::Set(di, limits.columns)),
                                hn::ConvertTo(di, column));
    const auto index = hn::IfThenElse(hn::RebindMask(di, visible), inside, hn::Set(di, -1));
    hn::StoreU(index, di, warped.target + x);
    // Phi = d_pred / d (eq. 3) is the ratio of depths, which is also defined for d = 0.
    hn::StoreU(moved, d, warped.disparity_px + x);
    hn::StoreU(hn::Mul(hn::Mul(scale, scale), hn::LoadU(d, variance_px2 + x)), d,
               warped.variance_px2 + x);
    hn::Store(hn::Min(hn::Load(du, first_targets), hn::BitCast(du, index)), du, first_targets);
    hn::Store(hn::Max(hn::Load(di, last_targets), index), di, last_targets);
  });
  const int last = *std::max_element(std::begin(lasts), std::end(lasts));
  const auto first = static_cast<int>(*std::min_element(std::begin(firsts), std::end(firsts)));
  warped.first_row = last < 0 ? limits.rows : first / limits.columns;
  warped.last_row = last < 0 ? -1 : last / limits.columns;
}

// Fills an invalid pixel with the average of `before` and `after` if both are valid; missed_frames
// is the larger of the two. The neighbours of a filled hole are known, so a filled value is never
// used again: all three may be parts of one row, one pixel apart.
void fillBetween(const PredictionRow& before, const PredictionRow& after, int width,
                 float smallest_valid, const PredictionRow& filled) {
  forPixels<float>(0, width, [=](auto d, int x) HWY_ATTR {
    const hn::RebindToSigned<decltype(d)> di;
    const hn::Rebind<uint8_t, decltype(d)> d8;
    const auto smallest = hn::Set(d, smallest_valid), half = hn::Set(d, 0.5f);
    const auto d0 = hn::LoadU(d, before.disparity_px + x);
    const auto d1 = hn::LoadU(d, filled.disparity_px + x);
    const auto d2 = hn::LoadU(d, after.disparity_px + x);
    const auto fillable = hn::And(hn::Ge(d0, smallest), hn::Ge(d2, smallest));
    const auto hole = hn::And(hn::Lt(d1, smallest), fillable);
    if (hn::AllFalse(d, hole)) return;

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
  });
}

PREDICTIVE_STEREO_END_KERNELS;

#if HWY_ONCE
namespace predictive_stereo {
namespace {

HWY_EXPORT(warpRow);
HWY_EXPORT(fillBetween);

RowMotion rowMotion(const Eigen::Matrix4d& H, int y) {
  RowMotion motion;
  for (int i = 0; i < 4; ++i) {
    motion.by_x[i] = static_cast<float>(H(i, 0));
    motion.by_d[i] = static_cast<float>(H(i, 2));
    motion.constant[i] = static_cast<float>(H(i, 1) * y + H(i, 3));
  }
  return motion;
}

// Work is distributed by bands of rows.
constexpr int kBandRows = 48;
int bandCount(cv::Size size) { return (size.height + kBandRows - 1) / kBandRows; }
cv::Range bandRows(int band, cv::Size size) {
  return {band * kBandRows, std::min((band + 1) * kBandRows, size.height)};
}

template <class Map>
void createWithoutGaps(cv::Size size, Map& map) {
  if (!map.isContinuous()) map.release();
  map.create(size);
}

PredictionRow row(Prediction& maps, int y, int x = 0) {
  return {maps.disparity_px[y] + x, maps.variance_px2[y] + x, maps.missed_frames[y] + x};
}

// The first and the last pixel have only one neighbour.
void fillWithinRow(float smallest_valid, int y, Prediction& maps) {
  const int inner = maps.disparity_px.cols - 2;
  HWY_DYNAMIC_DISPATCH(fillBetween)
  (row(maps, y, 0), row(maps, y, 2), inner, smallest_valid, row(maps, y, 1));
}

void fillFromRowsAround(float smallest_valid, int y, Prediction& maps) {
  const cv::Size size = maps.disparity_px.size();
  if (y == 0 || y + 1 == size.height) return;
  HWY_DYNAMIC_DISPATCH(fillBetween)
  (row(maps, y - 1), row(maps, y + 1), size.width, smallest_valid, row(maps, y));
}

}  // namespace

void addToDisparities(const DisparityRange& range, double offset_px, cv::Mat1f& disparity_px) {
  const auto smallest = static_cast<float>(range.min_disparity);
  cv::add(disparity_px, offset_px, disparity_px, disparity_px >= smallest);
  disparity_px.setTo(range.invalid(), disparity_px < smallest);
}

void addToDisparities(const DisparityRange& range, double offset_px, DisparityState& state) {
  if (state.empty()) return;
  addToDisparities(range, offset_px, state.disparity_px);
  state.variance_px2.setTo(0, state.disparity_px < static_cast<float>(range.min_disparity));
}

Predictor::Predictor(const DisparityRange& range, const PredictionParams& params)
    : range_(range), params_(params) {
  validate(params, "prediction/");
}

void Predictor::predict(const DisparityState& previous, const StereoRig& rig,
                        const CameraMotion& motion, Prediction& prediction) {
  warp(previous, rig, motion);
  scatterAndFill(previous, prediction);
  markNearEdgesAndAddNoise(rig, motion, prediction);
  if (params_.reject_near_edges) rejectNearEdges(prediction);
}

void Predictor::predictNothing(cv::Size size, Prediction& prediction) const {
  prediction.disparity_px.create(size);
  prediction.variance_px2.create(size);
  prediction.missed_frames.create(size);
  prediction.near_edge.create(size);
  prediction.disparity_px.setTo(range_.invalid());
  prediction.variance_px2.setTo(0);
  prediction.missed_frames.setTo(0);
  prediction.near_edge.setTo(0);
}

void Predictor::warp(const DisparityState& previous, const StereoRig& rig,
                     const CameraMotion& motion) {
  const cv::Size size = previous.disparity_px.size();
  const Eigen::Matrix4d H = disparityMotion(rig, motion.T_cam_prev);
  target_.create(size);
  target_disparity_px_.create(size);
  target_variance_px2_.create(size);
  target_rows_.resize(size.height);
  const WarpLimits limits{size.width, size.height, static_cast<float>(range_.min_disparity),
                          static_cast<float>(range_.max_disparity())};
  parallelForEach(size.height, [&](int y) {
    WarpedRow warped{target_[y], target_disparity_px_[y], target_variance_px2_[y], 0, 0};
    HWY_DYNAMIC_DISPATCH(warpRow)
    (rowMotion(H, y), previous.disparity_px[y], previous.variance_px2[y], limits, warped);
    target_rows_[y] = cv::Range(warped.first_row, warped.last_row + 1);
  });
}

// Bands of the current frame are independent, and within a band the previous frame's pixels come in
// a fixed order. The result therefore does not depend on the number of threads.
//
// Holes are filled along rows first, then along columns, so that crossings of missing rows and
// missing columns are filled. Within each step the order does not matter: a hole is filled only
// between two known neighbours, so no filled pixel fills another one. The first and last row of a
// band need a neighbouring band and come last.
void Predictor::scatterAndFill(const DisparityState& previous, Prediction& prediction) const {
  const cv::Size size = target_.size();
  createWithoutGaps(size, prediction.disparity_px);
  createWithoutGaps(size, prediction.variance_px2);
  createWithoutGaps(size, prediction.missed_frames);
  const auto smallest = static_cast<float>(range_.min_disparity);
  const int bands = bandCount(size);
  parallelForEach(bands, [&](int band) {
    const cv::Range rows = bandRows(band, size);
    scatterInto(rows, previous, prediction);
    for (int y = rows.start; y < rows.end; ++y) fillWithinRow(smallest, y, prediction);
    for (int y = rows.start + 1; y < rows.end - 1; ++y) fillFromRowsAround(smallest, y, prediction);
  });
  parallelForEach(bands - 1, [&](int band) {
    const int last = bandRows(band, size).end - 1;
    fillFromRowsAround(smallest, last, prediction);
    fillFromRowsAround(smallest, last + 1, prediction);
  });
}

// The z-buffer.
void Predictor::scatterInto(const cv::Range& rows, const DisparityState& previous,
                            Prediction& prediction) const {
  const int width = target_.cols;
  float* const disparity = prediction.disparity_px[rows.start];
  float* const variance = prediction.variance_px2[rows.start];
  uchar* const missed = prediction.missed_frames[rows.start];
  const auto pixels = static_cast<unsigned>(rows.size() * width);
  std::fill_n(disparity, pixels, range_.invalid());
  std::fill_n(variance, pixels, 0.0f);
  std::fill_n(missed, pixels, uchar{0});
  const int first = rows.start * width;
  for (int y = 0; y < target_.rows; ++y) {
    if (target_rows_[y].end <= rows.start || target_rows_[y].start >= rows.end) continue;
    const int* const target = target_[y];
    const float* const moved_disparity = target_disparity_px_[y];
    const float* const moved_variance = target_variance_px2_[y];
    const uchar* const previous_missed = previous.missed_frames[y];
    for (int x = 0; x < width; ++x) {
      const auto i = static_cast<unsigned>(target[x] - first);  // of another band: too large
      if (i >= pixels || moved_disparity[x] <= disparity[i]) continue;
      disparity[i] = moved_disparity[x];
      variance[i] = moved_variance[x];
      missed[i] = previous_missed[x];
    }
  }
}

}  // namespace predictive_stereo
#endif
