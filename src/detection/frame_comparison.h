#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "odometry/image_pyramid.h"
#include "predictive_stereo/disparity_motion.h"
#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

/// What the detector keeps of a frame for the next one.
struct RememberedFrame {
  double stamp_s = 0;
  bool has_pose = false;
  Eigen::Isometry3d T_odom_cam = Eigen::Isometry3d::Identity();
  ImagePyramid pyramid;
  cv::Mat1f disparity_px;  ///< as measured

  bool empty() const { return pyramid.empty(); }
};

/// Where a point (x, y, d) of the current frame was in the previous one; homogeneous, in pixels.
/// See disparityMotion.
class SourceOf {
 public:
  explicit SourceOf(const Eigen::Matrix4d& H_prev_cam) : h_(H_prev_cam.cast<float>()) {}
  Eigen::Vector3f operator()(float x, float y, float d) const {
    const Eigen::Vector4f p = h_.col(0) * x + h_.col(1) * y + h_.col(2) * d + h_.col(3);
    return p.head<3>() / p[3];
  }

 private:
  Eigen::Matrix4f h_;
};

/// How well an assumed motion explains the image, on a lattice of every second pixel and row:
/// lattice point (u, v) is pixel (2u, 2v).
struct Comparison {
  cv::Rect area;       ///< the part of the lattice that the maps cover
  cv::Mat1f mismatch;  ///< mean |difference| over 5x5 lattice points after the mean difference is
                       ///< taken away [grey values]; kUnknown where too little is known
  static constexpr float kUnknown = -1.0f;

  // Work space.
  cv::Mat1f difference, known, mean, count;
};

/// Compares the current image with the previous one as moved by H_prev_cam, through the measured
/// disparities.
/// @param source  empty, or filled with (x, y, d) of the previous frame, d < 0 where unknown.
void compareFrames(const ImagePyramid& current, const cv::Mat1f& disparity_px,
                   const DisparityRange& range, const ImagePyramid& previous,
                   const SourceOf& source_of, const cv::Rect& area, Comparison& comparison,
                   cv::Mat3f* source = nullptr);

/// Mean |grey - mean grey| over 5x5 lattice points: the mismatch that a wrong motion can show.
void latticeTexture(const ImagePyramid& current, cv::Mat1f& texture);

}  // namespace predictive_stereo
