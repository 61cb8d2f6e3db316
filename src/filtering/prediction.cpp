#include "predictive_stereo/prediction.h"

#include <algorithm>

#include "filtering/prediction_rows.h"
#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

RowMotion rowMotion(const Eigen::Matrix4d& H, int y) {
  RowMotion motion;
  for (int i = 0; i < 4; ++i) {
    motion.by_x[i] = static_cast<float>(H(i, 0));
    motion.by_d[i] = static_cast<float>(H(i, 2));
    motion.constant[i] = static_cast<float>(H(i, 1) * y + H(i, 3));
  }
  return motion;
}

// J Sigma J^T of the ego-motion for the pixels of one row, where J is the derivative of a disparity
// d by the perturbation of T_cam_prev. d = fB / Z, and the perturbation changes Z by t_z + (r x
// X)_z = t_z + r_x Y - r_y X: only three of the six components change a disparity.
RowNoise rowNoise(const StereoRig& rig, const Eigen::Matrix3d& sigma, double floor_px2, int y) {
  const double y_n = (y - rig.cy_px) / rig.fy_px;
  RowNoise noise;
  noise.floor_px2 = static_cast<float>(floor_px2);
  noise.zz = static_cast<float>(sigma(0, 0));
  noise.yy = static_cast<float>(sigma(1, 1) * y_n * y_n);
  noise.xx = static_cast<float>(sigma(2, 2));
  noise.zy = static_cast<float>(2 * sigma(0, 1) * y_n);
  noise.zx = static_cast<float>(2 * sigma(0, 2));
  noise.yx = static_cast<float>(2 * sigma(1, 2) * y_n);
  noise.per_fb = static_cast<float>(1.0 / rig.disparityTimesDepth());
  noise.per_fx = static_cast<float>(1.0 / rig.fx_px);
  noise.centre_column = static_cast<float>(rig.cx_left_px);
  return noise;
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

ConstPredictionRow row(const Prediction& maps, int y, int x = 0) {
  return {maps.disparity_px[y] + x, maps.variance_px2[y] + x, maps.missed_frames[y] + x};
}

MutablePredictionRow mutableRow(Prediction& maps, int y, int x = 0) {
  return {maps.disparity_px[y] + x, maps.variance_px2[y] + x, maps.missed_frames[y] + x};
}

// The first and the last pixel have only one neighbour.
void fillWithinRow(float smallest_valid, int y, Prediction& maps) {
  const int width = maps.disparity_px.cols;
  if (width > 2)
    fillBetween(row(maps, y, 0), row(maps, y, 2), width - 2, smallest_valid,
                mutableRow(maps, y, 1));
}

void fillFromRowsAround(float smallest_valid, int y, Prediction& maps) {
  const cv::Size size = maps.disparity_px.size();
  if (y > 0 && y + 1 < size.height)
    fillBetween(row(maps, y - 1), row(maps, y + 1), size.width, smallest_valid,
                mutableRow(maps, y));
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
    warpRow(rowMotion(H, y), previous.disparity_px[y], previous.variance_px2[y], limits, warped);
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
  parallelFor(cv::Range(1, bands), [&](const cv::Range& part) {
    for (int band = part.start; band < part.end; ++band) {
      const int first = bandRows(band, size).start;
      fillFromRowsAround(smallest, first - 1, prediction);
      fillFromRowsAround(smallest, first, prediction);
    }
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

// After all edges are found: bands read rows of their neighbours.
void Predictor::rejectNearEdges(Prediction& prediction) const {
  prediction.disparity_px.setTo(range_.invalid(), prediction.near_edge);
  prediction.variance_px2.setTo(0, prediction.near_edge);
  prediction.missed_frames.setTo(0, prediction.near_edge);
}

// A pixel is near an edge if an edge pixel is within the margin, in columns and in rows.
void Predictor::markNearEdgesAndAddNoise(const StereoRig& rig, const CameraMotion& motion,
                                         Prediction& prediction) {
  const cv::Size size = prediction.disparity_px.size();
  const int margin = params_.edge_margin_px, padded_width = size.width + 2 * margin;
  const float smallest = static_cast<float>(range_.min_disparity);
  const double any_disparity_px2 = static_cast<double>(range_.count) * range_.count / 12.0;
  Eigen::Matrix3d sigma = Eigen::Matrix3d::Zero();
  if (params_.use_motion_covariance) sigma = motion.covariance.block<3, 3>(2, 2);
  prediction.near_edge.create(size);

  const int bands = bandCount(size);
  const int band_marks = kBandRows + 2 * margin + 1;
  marks_.create(bands * band_marks, padded_width);
  parallelForEach(bands, [&](int band) {
    const cv::Range rows = bandRows(band, size);
    const cv::Range edge_rows(std::max(rows.start - margin, 0),
                              std::min(rows.end + margin, size.height));
    const int first_mark = band * band_marks;
    const auto edges = [&](int y) { return marks_[first_mark + 1 + y - edge_rows.start]; };
    for (int y = edge_rows.start; y < edge_rows.end; ++y) {
      std::fill_n(edges(y), margin, uchar{0});
      std::fill_n(edges(y) + margin + size.width, margin, uchar{0});
      markEdges(prediction.disparity_px[y],
                prediction.disparity_px[std::min(y + 1, size.height - 1)], size.width,
                static_cast<float>(params_.edge_jump_px), smallest, edges(y) + margin);
    }
    uchar* const column_marks = marks_[first_mark];
    for (int y = rows.start; y < rows.end; ++y) {
      std::fill_n(column_marks, padded_width, uchar{0});
      for (int i = std::max(y - margin, 0); i <= std::min(y + margin, size.height - 1); ++i)
        uniteMarks(edges(i), padded_width, column_marks);
      uchar* const near_edge = prediction.near_edge[y];
      std::fill_n(near_edge, size.width, uchar{0});
      for (int i = 0; i <= 2 * margin; ++i) uniteMarks(column_marks + i, size.width, near_edge);
      addNoiseOrReset(rowNoise(rig, sigma, params_.process_noise_px2, y),
                      prediction.disparity_px[y], near_edge, size.width, smallest,
                      static_cast<float>(any_disparity_px2), prediction.variance_px2[y]);
    }
  });
}

}  // namespace predictive_stereo
