/// Geometric primitives of the scenes, and their intersections with rays.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <limits>

namespace predictive_stereo::simulation {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector2f;
using Eigen::Vector3d;
using Eigen::Vector3f;

enum class Shape : uint8_t {
  kGround,     ///< the plane z = 0
  kBox,        ///< half sizes along the local axes
  kFrustum,    ///< a box whose top is smaller: car bodies, cabins, roofs
  kBuilding,   ///< a box with recessed windows on its walls
  kCylinder,   ///< axis z, radius half.x = half.y, half length half.z, with caps
  kEllipsoid,  ///< semi-axes
  kLeaves,     ///< a flat ragged disc with holes, normal to y, radii half.x and half.z
  kRing,       ///< a flat ring around y, outer radius half.x: bicycle wheels
  kBars,       ///< a plate normal to y with vertical gaps: fences
};

enum Material : uint8_t {
  kRoad,
  kPavement,
  kPlaster,
  kBrick,
  kRoof,
  kGlass,
  kLeaves,
  kBark,
  kPaint,  ///< of cars: glossy
  kCabin,  ///< of cars: windows between painted pillars
  kRubber,
  kCloth,
  kSkin,
  kMetal,
  kLamp,
  kSign,
  kLinoleum,    ///< floors: speckles and seams
  kPanels,      ///< ceilings
  kPrint,       ///< posters, boxes with print
  kChessboard,  ///< squares of 0.1 m inside a border
};

/// Windows of a building, repeated in cells along its walls.
struct Windows {
  float cell_width_m = 0, cell_height_m = 0;  ///< 0: none
  float width_m = 0, height_m = 0;            ///< of the opening, in the middle of its cell
  float recess_m = 0;                         ///< depth of the pane behind the wall
};

struct Primitive {
  Shape shape = Shape::kBox;
  Material material = kPlaster;
  int object = 0;  ///< number of its moving object; 0: the static world
  uint32_t seed = 0;
  float albedo = 0.5f;
  float contrast = 1.0f;                                        ///< of its texture
  Vector3d centre_m = Vector3d::Zero();                         ///< in the world
  Eigen::Matrix3f R_local_world = Eigen::Matrix3f::Identity();  ///< from world to local axes
  Vector3f half_m = Vector3f::Ones();
  // Frustum: its top reaches from x = top_back to x = top_front, and over |y| <= top_side.
  float top_back_m = 0, top_front_m = 0, top_side_m = 0;
  Windows windows;
};

/// First intersection of a ray with a primitive. The ray is origin + t * direction, and the
/// direction has depth 1, so t is the depth Z in the camera.
struct Hit {
  float t = std::numeric_limits<float>::infinity();  ///< [m], infinite: the sky
  int primitive = -1;                                ///< index, -1: the sky
  int part = 0;                                      ///< see below
  bool sunny = false;  ///< whether the sun shines on it; set by the camera

  bool sky() const { return primitive < 0; }
};

/// Parts of boxes and frusta: 0..5 are the faces -x +x -y +y -z +z. Windows of buildings have more:
/// the pane (kPane + wall) and the sides (kReveal + wall).
constexpr int kPane = 8, kReveal = 16;

constexpr float kNearest_m = 0.1f;  ///< nearer hits are ignored

/// Intersects `primitive` with a ray in its local axes; hits between kNearest_m and `hit.t` count.
/// @param pixel_per_m  width of a pixel at a depth of 1 m; finer holes are closed.
/// @return true if there is a hit; then its t and part are set.
bool intersect(const Primitive& primitive, const Vector3f& origin, const Vector3f& direction,
               float pixel_per_m, Hit& hit);

/// The surface at a local point: outward normal, and coordinates [m] for textures.
struct Surface {
  Vector3f normal;
  Vector3f axis_u, axis_v;  ///< tangents of u and v; zero for curved surfaces
  double u_m = 0, v_m = 0;
};
Surface surfaceAt(const Primitive& primitive, int part, const Vector3f& point);

}  // namespace predictive_stereo::simulation
