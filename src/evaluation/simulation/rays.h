/// Rays through the primitives, by spatial indices.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "evaluation/simulation/primitive.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo::simulation {

/// For each tile of a rectangle, the items whose bounds overlap it, in the order of adding.
class Tiles {
 public:
  struct Item {
    Eigen::AlignedBox2f bounds;
    float nearest;  ///< lower bound of its distance
    int index;
  };

  Tiles(const Eigen::AlignedBox2f& area, float tile_size);
  void add(const std::vector<Item>& items);
  /// The list at a point. Points outside the area get that of the nearest tile.
  const std::vector<Item>& at(float x, float y) const {
    return lists_[tileOf(y - area_.min().y(), rows_) * columns_ +
                  tileOf(x - area_.min().x(), columns_)];
  }

 private:
  size_t tileOf(float offset, size_t count) const;

  Eigen::AlignedBox2f area_;
  float per_tile_;
  size_t columns_, rows_;
  std::vector<std::vector<Item>> lists_;
};

/// Casts rays from one camera. Rays are given by ideal pixel coordinates, up to `kMargin_px`
/// outside the image.
class RayGrid {
 public:
  static constexpr int kTile_px = 16, kMargin_px = 16;

  /// @param primitives  must outlive the grid.
  /// @param cx_px  of this camera; the rest of the rig is common to both cameras.
  RayGrid(const std::vector<Primitive>& primitives, const Isometry3d& T_world_cam,
          const StereoRig& rig, double cx_px);

  /// First hit of the ray through (x, y).
  Hit cast(float x_px, float y_px) const;

  /// Whether the ray through (x, y) hits this primitive.
  bool meets(int primitive, float x_px, float y_px) const;

  Vector3f directionOf(float x_px, float y_px) const {
    return R_world_cam_ * Vector3f((x_px - cx_) * inverse_f_, (y_px - cy_) * inverse_fy_, 1);
  }
  const Vector3d& centre_m() const { return centre_m_; }  ///< of the camera, in the world
  float pixelPerM() const { return inverse_f_; }
  int count() const { return static_cast<int>(origins_.size()); }
  /// The camera's position in the local axes of a primitive.
  const Vector3f& originIn(int primitive) const { return origins_[static_cast<size_t>(primitive)]; }
  const Primitive& primitive(int index) const { return primitives_[static_cast<size_t>(index)]; }

  /// Bounds of the pixels that the primitive can cover, not clipped; empty behind the camera.
  const Eigen::AlignedBox2f& boundsOf(int primitive) const {
    return items_[static_cast<size_t>(primitive)].bounds;
  }

 private:
  const std::vector<Primitive>& primitives_;
  std::vector<Vector3f> origins_;  // of the camera in the primitives' axes
  std::vector<Tiles::Item> items_;
  Tiles tiles_;  // of the image, nearest primitives first
  Vector3d centre_m_;
  Eigen::Matrix3f R_world_cam_;
  float cx_, cy_, inverse_f_, inverse_fy_;
};

/// Casts rays to the sun from any point, given relative to a centre (world axes).
class Shadows {
 public:
  static constexpr float kReach_m = 110;  ///< no shadows farther from the centre

  /// @param primitives  must outlive the shadows.
  Shadows(const std::vector<Primitive>& primitives, const Vector3f& to_sun,
          const Vector3d& centre_m);

  const Vector3d& centre_m() const { return centre_m_; }  ///< in the world

  /// Whether the sun shines on this point. Surfaces within kNearest_m of it cast no shadow.
  bool sunReaches(const Vector3f& point_m) const;

 private:
  const std::vector<Primitive>& primitives_;
  Vector3d centre_m_;
  Vector3f to_sun_, across_, up_;  // the latter are normal to the sun's rays
  std::vector<Vector3f> centres_m_;
  Tiles tiles_;  // of a plane normal to the sun's rays
};

}  // namespace predictive_stereo::simulation
