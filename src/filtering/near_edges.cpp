#include <algorithm>
#include <cmath>

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

void uniteMarks(const uint8_t* HWY_RESTRICT marks, int width, uint8_t* HWY_RESTRICT united) {
  for (int x = 0; x < width; ++x) united[x] = united[x] | marks[x];
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
HWY_EXPORT(uniteMarks);
HWY_EXPORT(addNoiseOrReset);

constexpr int kBandRows = 48;  // work is distributed by bands of rows

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

  const int bands = (size.height + kBandRows - 1) / kBandRows;
  const int band_marks = kBandRows + 2 * margin + 1;
  marks_.create(bands * band_marks, padded_width);
  parallelForEach(bands, [&](int band) {
    const cv::Range rows(band * kBandRows, std::min((band + 1) * kBandRows, size.height));
    const cv::Range edge_rows(std::max(rows.start - margin, 0),
                              std::min(rows.end + margin, size.height));
    const int first_mark = band * band_marks;
    const auto edges = [&](int y) { return marks_[first_mark + 1 + y - edge_rows.start]; };
    for (int y = edge_rows.start; y < edge_rows.end; ++y) {
      std::fill_n(edges(y), margin, uchar{0});
      std::fill_n(edges(y) + margin + size.width, margin, uchar{0});
      HWY_DYNAMIC_DISPATCH(markEdges)
      (prediction.disparity_px[y], prediction.disparity_px[std::min(y + 1, size.height - 1)],
       size.width, static_cast<float>(params_.edge_jump_px), smallest, edges(y) + margin);
    }
    uchar* const column_marks = marks_[first_mark];
    for (int y = rows.start; y < rows.end; ++y) {
      std::fill_n(column_marks, padded_width, uchar{0});
      for (int i = std::max(y - margin, 0); i <= std::min(y + margin, size.height - 1); ++i)
        HWY_DYNAMIC_DISPATCH(uniteMarks)(edges(i), padded_width, column_marks);
      uchar* const near_edge = prediction.near_edge[y];
      std::fill_n(near_edge, size.width, uchar{0});
      for (int i = 0; i <= 2 * margin; ++i)
        HWY_DYNAMIC_DISPATCH(uniteMarks)(column_marks + i, size.width, near_edge);
      HWY_DYNAMIC_DISPATCH(addNoiseOrReset)
      (rowNoise(rig, sigma, params_.process_noise_px2, y), prediction.disparity_px[y], near_edge,
       size.width, smallest, static_cast<float>(any_disparity_px2), prediction.variance_px2[y]);
    }
  });
}

}  // namespace predictive_stereo
#endif
