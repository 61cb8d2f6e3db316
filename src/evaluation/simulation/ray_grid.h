/// Spatial index of the primitives for rays from one camera: lists by tile of its image.
#pragma once

#include <Eigen/Geometry>
#include <limits>
#include <vector>

#include "evaluation/simulation/primitive.h"
#include "evaluation/simulation/tiles.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo::simulation {

/// Casts rays from one camera. Rays are given by ideal pixel coordinates, up to `kMargin_px`
/// outside the image.
class RayGrid {
 public:
  static constexpr int kTile_px = 16, kMargin_px = 16;

  /// @param primitives  must outlive the grid.
  /// @param cx_px  of this camera; the rest of the rig is common to both cameras.
  RayGrid(const std::vector<Primitive>& primitives, const Eigen::Isometry3d& T_world_cam,
          const StereoRig& rig, double cx_px);

  /// First hit of the ray through (x, y) nearer than `limit_m`; primitive `except` is ignored.
  Hit cast(float x_px, float y_px, float limit_m = std::numeric_limits<float>::infinity(),
           int except = -1) const;

  /// Whether the ray hits anything nearer than `limit_m`.
  bool blocked(float x_px, float y_px, float limit_m) const;

  /// Whether the ray through (x, y) hits this primitive.
  bool meets(int primitive, float x_px, float y_px) const;

  Eigen::Vector3f directionOf(float x_px, float y_px) const {
    return R_world_cam_ * Eigen::Vector3f((x_px - cx_) * inverse_f_, (y_px - cy_) * inverse_fy_, 1);
  }
  float pixelPerM() const { return inverse_f_; }
  int count() const { return static_cast<int>(origins_.size()); }
  /// The camera's position in the local axes of a primitive.
  const Eigen::Vector3f& originIn(int primitive) const {
    return origins_[static_cast<size_t>(primitive)];
  }
  const Primitive& primitive(int index) const { return (*primitives_)[static_cast<size_t>(index)]; }

  /// Bounds of the pixels that the primitive can cover, not clipped; empty behind the camera.
  cv::Rect2f boundsOf(int primitive) const;

 private:
  const std::vector<Primitive>* primitives_;
  std::vector<Eigen::Vector3f> origins_;  // of the camera in the primitives' axes
  std::vector<Tiles::Item> items_;
  Tiles tiles_;  // of the image, nearest primitives first
  Eigen::Matrix3f R_world_cam_;
  float cx_, cy_, inverse_f_, inverse_fy_;
};

}  // namespace predictive_stereo::simulation
