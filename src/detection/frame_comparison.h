#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "imaging/image_pyramid.h"
#include "predictive_stereo/disparity_motion.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

/// Maps a point (x, y, d) [px] of the current frame to the previous one. See disparityMotion.
class SourceOf {
 public:
  explicit SourceOf(const Eigen::Matrix4d& H_prev_cam) : h_(H_prev_cam.cast<float>()) {}
  const Eigen::Matrix4f& H() const { return h_; }
  Eigen::Vector3f operator()(float x, float y, float d) const {
    const Eigen::Vector4f p = h_.col(0) * x + h_.col(1) * y + h_.col(2) * d + h_.col(3);
    return p.head<3>() / p[3];
  }

 private:
  Eigen::Matrix4f h_;
};

/// A map of a past frame, for loops over rows.
struct PastMap {
  const float* H;  ///< 4x4, column-major: maps (x, y, d, 1) to that frame, see SourceOf
  int stride, columns, rows;
};

constexpr float kUnknownMismatch = -1;

/// Compares the current image with the previous one, warped by source_of through the measured
/// disparities, on a lattice of every second pixel and row: lattice point (u, v) is pixel (2u, 2v).
/// The loops are compiled for every SIMD target: each gives the same results, bit by bit.
/// @param lattice_px  disparities of the lattice points; 0: unknown.
/// @param area  the part of the lattice that is compared.
/// @param mismatch  of the area's size: mean |difference| over 5x5 lattice points after subtracting
///   the mean difference [grey levels]; kUnknownMismatch if too few points are known.
void compareFrames(const ImagePyramid& current, const cv::Mat1f& lattice_px,
                   const ImagePyramid& previous, const SourceOf& source_of, const cv::Rect& area,
                   cv::Mat1f& mismatch);

}  // namespace predictive_stereo
