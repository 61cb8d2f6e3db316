#include "predictive_stereo/prediction.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "filtering/prediction_rows.h"

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

// J Sigma J^T of the ego-motion for the pixels of one row, see disparityJacobian: of its six
// components only Z, pitch and yaw change a disparity.
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

template <class Maps>
void create(cv::Size size, Maps& maps) {
  maps.disparity_px.create(size);
  maps.variance_px2.create(size);
  maps.missed_frames.create(size);
}

template <class Maps>
ConstPredictionRow row(const Maps& maps, int y, int x) {
  return {maps.disparity_px[y] + x, maps.variance_px2[y] + x, maps.missed_frames[y] + x};
}

template <class Maps>
MutablePredictionRow mutableRow(Maps& maps, int y, int x) {
  return {maps.disparity_px[y] + x, maps.variance_px2[y] + x, maps.missed_frames[y] + x};
}

}  // namespace

Predictor::Predictor(const DisparityRange& range, const PredictionParams& params)
    : range_(range), params_(params) {
  validate(params, "prediction/");
}

void Predictor::predict(const DisparityState& previous, const StereoRig& rig,
                        const CameraMotion& motion, Prediction& prediction) {
  warp(previous, rig, motion);
  scatter(previous);
  fillHoles(prediction);
  markNearEdges(prediction);
  addProcessNoise(rig, motion, prediction);
}

void Predictor::predictNothing(cv::Size size, Prediction& prediction) const {
  create(size, prediction);
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
  cv::parallel_for_(cv::Range(0, size.height), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y) {
      WarpedRow warped{target_[y], target_disparity_px_[y], target_variance_px2_[y], 0, 0};
      warpRow(rowMotion(H, y), previous.disparity_px[y], previous.variance_px2[y], limits, warped);
      target_rows_[y] = cv::Range(warped.first_row, warped.last_row + 1);
    }
  });
}

// Bands of the current frame do not depend on each other, and within a band the previous frame's
// pixels come in a fixed order: so the result does not depend on which thread does which band.
void Predictor::scatter(const DisparityState& previous) {
  const cv::Size size = target_.size();
  create(size, warped_);
  constexpr int kBandRows = 32;
  const int bands = (size.height + kBandRows - 1) / kBandRows;

  cv::parallel_for_(cv::Range(0, bands), [&](const cv::Range& part) {
    const cv::Range rows(part.start * kBandRows, std::min(part.end * kBandRows, size.height));
    warped_.disparity_px.rowRange(rows).setTo(range_.invalid());
    warped_.variance_px2.rowRange(rows).setTo(0);
    warped_.missed_frames.rowRange(rows).setTo(0);
    float* disparity = warped_.disparity_px[0];
    float* variance = warped_.variance_px2[0];
    uchar* missed = warped_.missed_frames[0];
    const int first = rows.start * size.width, end = rows.end * size.width;
    for (int y = 0; y < size.height; ++y) {
      if (target_rows_[y].end <= rows.start || target_rows_[y].start >= rows.end) continue;
      const int* target = target_[y];
      const float* moved_disparity = target_disparity_px_[y];
      for (int x = 0; x < size.width; ++x) {
        const int i = target[x];
        if (i < first || i >= end || moved_disparity[x] <= disparity[i]) continue;
        disparity[i] = moved_disparity[x];
        variance[i] = target_variance_px2_(y, x);
        missed[i] = previous.missed_frames(y, x);
      }
    }
  });
}

// Rows first and then columns, so that the crossings of missing rows and missing columns are
// filled.
void Predictor::fillHoles(Prediction& prediction) {
  const cv::Size size = warped_.disparity_px.size();
  const float smallest = static_cast<float>(range_.min_disparity);
  create(size, rows_filled_);
  create(size, prediction);
  cv::parallel_for_(cv::Range(0, size.height), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y) {
      const int last = size.width - 1;
      // The first and the last pixel have one neighbour only.
      for (const int x : {0, last}) {
        rows_filled_.disparity_px(y, x) = warped_.disparity_px(y, x);
        rows_filled_.variance_px2(y, x) = warped_.variance_px2(y, x);
        rows_filled_.missed_frames(y, x) = warped_.missed_frames(y, x);
      }
      if (last > 1)
        fillBetween(row(warped_, y, 0), row(warped_, y, 1), row(warped_, y, 2), last - 1, smallest,
                    mutableRow(rows_filled_, y, 1));
    }
  });
  cv::parallel_for_(cv::Range(0, size.height), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y) {
      const bool inside = y > 0 && y + 1 < size.height;  // else nothing lies on one of the sides
      fillBetween(row(rows_filled_, inside ? y - 1 : y, 0), row(rows_filled_, y, 0),
                  row(rows_filled_, inside ? y + 1 : y, 0), size.width, smallest,
                  mutableRow(prediction, y, 0));
    }
  });
}

void Predictor::markNearEdges(Prediction& prediction) {
  const cv::Size size = prediction.disparity_px.size();
  edges_.create(size);
  cv::parallel_for_(cv::Range(0, size.height), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y)
      markEdges(prediction.disparity_px[y],
                prediction.disparity_px[std::min(y + 1, size.height - 1)], size.width,
                static_cast<float>(params_.edge_jump_px), static_cast<float>(range_.min_disparity),
                edges_[y]);
  });
  const int side = 2 * params_.edge_margin_px + 1;
  cv::dilate(edges_, prediction.near_edge, cv::Mat1b::ones(side, side));
}

void Predictor::addProcessNoise(const StereoRig& rig, const CameraMotion& motion,
                                Prediction& prediction) const {
  const cv::Size size = prediction.disparity_px.size();
  const double any_disparity_px2 = static_cast<double>(range_.count) * range_.count / 12.0;
  Eigen::Matrix3d sigma = Eigen::Matrix3d::Zero();
  if (params_.use_motion_covariance) sigma = motion.covariance.block<3, 3>(2, 2);
  cv::parallel_for_(cv::Range(0, size.height), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y)
      addNoiseOrReset(rowNoise(rig, sigma, params_.process_noise_px2, y),
                      prediction.disparity_px[y], prediction.near_edge[y], size.width,
                      static_cast<float>(range_.min_disparity),
                      static_cast<float>(any_disparity_px2), prediction.variance_px2[y]);
  });
}

}  // namespace predictive_stereo
