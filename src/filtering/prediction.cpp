#include "predictive_stereo/prediction.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace predictive_stereo {
namespace {

constexpr int kNowhere = -1;

// H of eq. 2 for the pixels of one row: everything that depends on y alone is added up once.
struct RowMotion {
  RowMotion(const Eigen::Matrix4d& H, int y) {
    for (int i = 0; i < 4; ++i) {
      by_x[i] = static_cast<float>(H(i, 0));
      by_d[i] = static_cast<float>(H(i, 2));
      constant[i] = static_cast<float>(H(i, 1) * y + H(i, 3));
    }
  }
  float component(int i, float x, float d) const { return by_x[i] * x + by_d[i] * d + constant[i]; }
  float by_x[4], by_d[4], constant[4];
};

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
  addProcessNoise(rig, motion, prediction);
  resetNearEdges(prediction);
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
  const float smallest = static_cast<float>(range_.min_disparity);
  const float largest = static_cast<float>(range_.max_disparity());
  const float columns = static_cast<float>(size.width);
  const float rows = static_cast<float>(size.height);

  cv::parallel_for_(cv::Range(0, size.height), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y) {
      const RowMotion row_motion(H, y);
      const float* disparity = previous.disparity_px[y];
      const float* variance = previous.variance_px2[y];
      int* target = target_[y];
      float* moved_disparity = target_disparity_px_[y];
      float* moved_variance = target_variance_px2_[y];
      int first_row = size.height, last_row = -1;
      for (int x = 0; x < size.width; ++x) {
        const float xf = static_cast<float>(x);
        const float d = disparity[x];
        const float w = row_motion.component(3, xf, d);  // Z / Z_prev: positive in front
        const float scale = 1.0f / w;
        const float column = row_motion.component(0, xf, d) * scale + 0.5f;
        const float row = row_motion.component(1, xf, d) * scale + 0.5f;
        const float moved = row_motion.component(2, xf, d) * scale;
        const bool visible = (d >= smallest) & (w > 0.0f) & (column >= 0.0f) & (column < columns) &
                             (row >= 0.0f) & (row < rows) & (moved >= smallest) &
                             (moved <= largest);
        const int target_row = static_cast<int>(visible ? row : 0.0f);
        const int target_column = static_cast<int>(visible ? column : 0.0f);
        target[x] = visible ? target_row * size.width + target_column : kNowhere;
        first_row = std::min(first_row, visible ? target_row : size.height);
        last_row = std::max(last_row, visible ? target_row : -1);
        // Phi = d_pred / d (eq. 3) is the depth ratio 1 / w, which also exists where d = 0.
        moved_disparity[x] = moved;
        moved_variance[x] = scale * scale * variance[x];
      }
      target_rows_[y] = cv::Range(first_row, last_row + 1);
    }
  });
}

// Bands of the current frame do not depend on each other, and within a band the previous frame's
// pixels come in a fixed order: so the result does not depend on which thread does which band.
void Predictor::scatter(const DisparityState& previous) {
  const cv::Size size = target_.size();
  warped_disparity_px_.create(size);
  warped_variance_px2_.create(size);
  warped_missed_frames_.create(size);
  constexpr int kBandRows = 32;
  const int bands = (size.height + kBandRows - 1) / kBandRows;

  cv::parallel_for_(cv::Range(0, bands), [&](const cv::Range& part) {
    const cv::Range rows(part.start * kBandRows, std::min(part.end * kBandRows, size.height));
    warped_disparity_px_.rowRange(rows).setTo(range_.invalid());
    warped_variance_px2_.rowRange(rows).setTo(0);
    warped_missed_frames_.rowRange(rows).setTo(0);
    float* disparity = warped_disparity_px_[0];
    float* variance = warped_variance_px2_[0];
    uchar* missed = warped_missed_frames_[0];
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
  const cv::Size size = warped_disparity_px_.size();
  const float invalid = range_.invalid();
  const auto averageOfWarped = [&](cv::Point a, cv::Point b, cv::Mat1f& disparity_px,
                                   cv::Mat1f& variance_px2, cv::Mat1b& missed, cv::Point at) {
    disparity_px(at) = 0.5f * (warped_disparity_px_(a) + warped_disparity_px_(b));
    variance_px2(at) = 0.5f * (warped_variance_px2_(a) + warped_variance_px2_(b));
    missed(at) = std::max(warped_missed_frames_(a), warped_missed_frames_(b));
  };
  // In place: of two holes side by side neither has two known neighbours.
  cv::parallel_for_(cv::Range(0, size.height), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y) {
      const float* row = warped_disparity_px_[y];
      for (int x = 1; x + 1 < size.width; ++x)
        if ((row[x] == invalid) & (row[x - 1] != invalid) & (row[x + 1] != invalid))
          averageOfWarped({x - 1, y}, {x + 1, y}, warped_disparity_px_, warped_variance_px2_,
                          warped_missed_frames_, {x, y});
    }
  });
  warped_disparity_px_.copyTo(prediction.disparity_px);
  warped_variance_px2_.copyTo(prediction.variance_px2);
  warped_missed_frames_.copyTo(prediction.missed_frames);
  cv::parallel_for_(cv::Range(1, std::max(size.height - 1, 1)), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y) {
      const float* row = warped_disparity_px_[y];
      const float* above = warped_disparity_px_[y - 1];
      const float* below = warped_disparity_px_[y + 1];
      for (int x = 0; x < size.width; ++x)
        if ((row[x] == invalid) & (above[x] != invalid) & (below[x] != invalid))
          averageOfWarped({x, y - 1}, {x, y + 1}, prediction.disparity_px, prediction.variance_px2,
                          prediction.missed_frames, {x, y});
    }
  });
}

void Predictor::addProcessNoise(const StereoRig& rig, const CameraMotion& motion,
                                Prediction& prediction) const {
  const cv::Size size = prediction.disparity_px.size();
  const float invalid = range_.invalid();
  const float floor = static_cast<float>(params_.process_noise_px2);
  // Of the motion's six components only Z, pitch and yaw change a disparity: J Sigma J^T with
  // J = -d (d / fb, y_n, -x_n), see disparityJacobian.
  Eigen::Matrix3f sigma = Eigen::Matrix3f::Zero();
  if (params_.use_motion_covariance) sigma = motion.covariance.block<3, 3>(2, 2).cast<float>();
  const float per_fb = static_cast<float>(1.0 / rig.disparityTimesDepth());
  const float per_fx = static_cast<float>(1.0 / rig.fx_px);
  const float cx = static_cast<float>(rig.cx_left_px);
  cv::parallel_for_(cv::Range(0, size.height), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y) {
      const float y_n = static_cast<float>((y - rig.cy_px) / rig.fy_px);
      const float* disparity = prediction.disparity_px[y];
      float* variance = prediction.variance_px2[y];
      for (int x = 0; x < size.width; ++x) {
        const float d = disparity[x];
        const float z = d * per_fb;
        const float x_n = (static_cast<float>(x) - cx) * per_fx;
        const float form =
            sigma(0, 0) * z * z + sigma(1, 1) * y_n * y_n + sigma(2, 2) * x_n * x_n +
            2.0f * (sigma(0, 1) * z * y_n - sigma(0, 2) * z * x_n - sigma(1, 2) * y_n * x_n);
        variance[x] += d != invalid ? floor + d * d * form : 0.0f;
      }
    }
  });
}

void Predictor::resetNearEdges(Prediction& prediction) {
  const cv::Size size = prediction.disparity_px.size();
  edges_.create(size);
  const float invalid = range_.invalid();
  const float jump = static_cast<float>(params_.edge_jump_px);
  cv::parallel_for_(cv::Range(0, size.height), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y) {
      const float* row = prediction.disparity_px[y];
      const float* below = prediction.disparity_px[std::min(y + 1, size.height - 1)];
      uchar* edge = edges_[y];
      const auto jumps = [&](float a, float b) {
        return (std::abs(a - b) > jump) & (a != invalid) & (b != invalid);
      };
      const int last = size.width - 1;
      for (int x = 0; x < last; ++x)
        edge[x] = (jumps(row[x], row[x + 1]) | jumps(row[x], below[x])) ? 255 : 0;
      edge[last] = jumps(row[last], below[last]) ? 255 : 0;
    }
  });
  const int side = 2 * params_.edge_margin_px + 1;
  cv::dilate(edges_, prediction.near_edge, cv::Mat1b::ones(side, side));

  const float count = static_cast<float>(range_.count);
  const float any_disparity_px2 = count * count / 12.0f;
  cv::parallel_for_(cv::Range(0, size.height), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y) {
      const float* disparity = prediction.disparity_px[y];
      const uchar* near_edge = prediction.near_edge[y];
      float* variance = prediction.variance_px2[y];
      for (int x = 0; x < size.width; ++x) {
        const bool reset = (near_edge[x] != 0) & (disparity[x] != invalid);
        variance[x] = reset ? any_disparity_px2 : variance[x];
      }
    }
  });
}

}  // namespace predictive_stereo
