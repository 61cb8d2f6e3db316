/// What surfaces look like.
#pragma once

#include "simulation/noise.h"
#include "simulation/primitive.h"

namespace predictive_stereo::simulation {

/// Lamps in a square lattice under the ceiling, that shine down: lamp (0, 0) is above the world's
/// origin.
struct CeilingLamps {
  float pitch_m = 0;  ///< from one to the next; 0: none
  float height_m = 2.7f;
  float strength = 1;  ///< illumination of a floor 1 m below one lamp
};

/// Light and surfaces of a scene.
struct Look {
  Eigen::Vector3f to_sun = Eigen::Vector3f(0.35f, -0.5f, 0.8f).normalized();
  float sun = 0.75f;         ///< strength of the direct light
  float ambient = 0.45f;     ///< light from everywhere
  float sky = 1.15f;         ///< radiance of the sky; 1 / exposure and more saturates
  float contrast = 1.0f;     ///< of all textures; near 0: nothing to match
  float reflections = 1.0f;  ///< of glass and paint: they move with the camera
  float headlights = 0;      ///< light from the camera's own vehicle, below the horizon
  float lamps = 0;           ///< radiance of lamps that shine: street lamps, headlights
  CeilingLamps ceiling;
  bool glossy_cars = false;  ///< see glossy.h
};

/// The diffuse albedo of a surface, within about 0..1.
float albedoOf(const Primitive& primitive, int part, const Surface& surface,
               const Eigen::Vector3f& local_m, const Footprint& footprint, float contrast);

/// Share of light that the surface reflects as a mirror, looked at along its normal; 0: none.
float mirrorOf(const Primitive& primitive, int part, const Eigen::Vector3f& local_m);

/// What the lamps of a ceiling give to a surface at this point of the world. They cast no shadows.
float lampLight(const CeilingLamps& lamps, const Eigen::Vector3f& point_m,
                const Eigen::Vector3f& normal);

/// Is this a window that one sees through?
bool isClear(const Primitive& primitive, int part, const Eigen::Vector3f& local_m);

/// Radiance that a mirror reflects from this direction (unit length, world): sky and, below, a
/// blurred street.
float surroundings(const Eigen::Vector3f& direction, const Look& look, uint32_t seed);

/// Radiance of the sky in this direction (any length, world).
float skyRadiance(const Eigen::Vector3f& direction, float pixel_per_m, const Look& look,
                  uint32_t seed);

}  // namespace predictive_stereo::simulation
