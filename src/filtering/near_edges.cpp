#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "parallel/tasks.h"
#include "predictive_stereo/prediction.h"
#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filtering/near_edges.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef PREDICTIVE_STEREO_ROW_NOISE
#define PREDICTIVE_STEREO_ROW_NOISE
namespace predictive_stereo {

/// Process noise of one row: floor + d^2 (J / d) Sigma (J / d)^T with J / d = (d / fb, y_n, -x_n)
/// up to sign.
struct RowNoise {
  float floor_px2;
  float zz, yy, xx;             ///< variances; factors of y_n are included
  float zy, zx, yx;             ///< twice the covariances; factors of y_n are included
  float per_fb;                 ///< 1 / (fx baseline)
  float per_fx, centre_column;  ///< x_n = (x - centre_column) per_fx
};

}  // namespace predictive_stereo
#endif

PREDICTIVE_STEREO_BEGIN_KERNELS;

// Marks (255) pixels that differ from their right or their lower neighbour by more than `jump_px`.
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

// Adds the process noise to the variance of valid pixels; near edges it becomes `reset_px2`.
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

PREDICTIVE_STEREO_END_KERNELS;

#if HWY_ONCE
namespace predictive_stereo {
namespace {

HWY_EXPORT(markEdges);
HWY_EXPORT(addNoiseOrReset);

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

}  // namespace

void Predictor::rejectNearEdges(Prediction& prediction) const {
  prediction.disparity_px.setTo(range_.invalid(), prediction.near_edge);
  prediction.variance_px2.setTo(0, prediction.near_edge);
  prediction.missed_frames.setTo(0, prediction.near_edge);
}

// A pixel is near an edge if an edge pixel is within the margin, in columns and in rows.
void Predictor::markNearEdgesAndAddNoise(const StereoRig& rig, const CameraMotion& motion,
                                         Prediction& prediction) {
  const cv::Size size = prediction.disparity_px.size();
  const float smallest = static_cast<float>(range_.min_disparity);
  const double any_disparity_px2 = static_cast<double>(range_.count) * range_.count / 12.0;
  Eigen::Matrix3d sigma = Eigen::Matrix3d::Zero();
  if (params_.use_motion_covariance) sigma = motion.covariance.block<3, 3>(2, 2);
  prediction.near_edge.create(size);

  parallelForEach(size.height, [&](int y) {
    HWY_DYNAMIC_DISPATCH(markEdges)
    (prediction.disparity_px[y], prediction.disparity_px[std::min(y + 1, size.height - 1)],
     size.width, static_cast<float>(params_.edge_jump_px), smallest, prediction.near_edge[y]);
  });
  const int square = 2 * params_.edge_margin_px + 1;
  cv::dilate(prediction.near_edge, prediction.near_edge, cv::Mat1b::ones(square, square), {-1, -1},
             1, cv::BORDER_CONSTANT | cv::BORDER_ISOLATED);
  parallelForEach(size.height, [&](int y) {
    HWY_DYNAMIC_DISPATCH(addNoiseOrReset)
    (rowNoise(rig, sigma, params_.process_noise_px2, y), prediction.disparity_px[y],
     prediction.near_edge[y], size.width, smallest, static_cast<float>(any_disparity_px2),
     prediction.variance_px2[y]);
  });
}

}  // namespace predictive_stereo
#endif
