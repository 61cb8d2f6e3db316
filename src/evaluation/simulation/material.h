/// Appearance of surfaces and of the sky.
#pragma once

#include "evaluation/simulation/noise.h"
#include "evaluation/simulation/primitive.h"

namespace predictive_stereo::simulation {

/// Lamps in a square lattice under the ceiling, which shine downwards. Lamp (0, 0) is above the
/// world's origin.
struct CeilingLamps {
  float pitch_m = 0;  ///< distance of neighbours; 0: no lamps
  float height_m = 2.7f;
  float strength = 1;  ///< illumination of a floor 1 m below one lamp
};

/// Light and surfaces of a scene.
struct Look {
  Vector3f to_sun = Vector3f(0.35f, -0.5f, 0.8f).normalized();
  float sun = 0.75f;         ///< strength of the direct light
  float ambient = 0.45f;     ///< strength of the ambient light
  float sky = 1.15f;         ///< radiance of the sky; 1 / exposure and more saturates
  float contrast = 1.0f;     ///< of all textures; near 0: no texture to match
  float reflections = 1.0f;  ///< strength of those of glass and paint; they move with the camera
  float headlights = 0;      ///< light from the camera's own vehicle, below the horizon
  float lamps = 0;           ///< radiance of street lamps and headlights
  CeilingLamps ceiling;
};

/// Diffuse albedo of a surface, between about 0 and 1.
float albedoOf(const Primitive& primitive, int part, const Surface& surface,
               const Vector3f& local_m, const Footprint& footprint, float contrast);

/// Share of light that the surface reflects specularly, for a view along its normal.
float mirrorOf(const Primitive& primitive, int part, const Vector3f& local_m);

/// Illumination of a surface at this point of the world by the ceiling lamps, without shadows.
float lampLight(const CeilingLamps& lamps, const Vector3f& point_m, const Vector3f& normal);

/// Radiance that a mirror reflects from this direction (unit length, world): the sky and, below the
/// horizon, a blurred street.
float surroundings(const Vector3f& direction, const Look& look, uint32_t seed);

/// Radiance of the sky in this direction (any length, world).
float skyRadiance(const Vector3f& direction, float pixel_per_m, const Look& look, uint32_t seed);

}  // namespace predictive_stereo::simulation
