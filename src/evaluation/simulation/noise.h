/// Random numbers that are pure functions of their arguments, and textures made from them.
#pragma once

#include <cstdint>

namespace predictive_stereo::simulation {

inline uint32_t mix(uint32_t h) {
  h ^= h >> 16;
  h *= 0x7feb352dU;
  h ^= h >> 15;
  h *= 0x846ca68bU;
  h ^= h >> 16;
  return h;
}

inline uint32_t hashOf(uint32_t a, uint32_t b = 0, uint32_t c = 0, uint32_t d = 0) {
  return mix(mix(mix(mix(a) + b) + c) + d);
}

/// A short random sequence that is the same on every machine.
class Random {
 public:
  explicit Random(uint32_t seed) : state_(seed) {}
  uint32_t bits() { return mix(state_ += 0x9e3779b9U); }
  double uniform() { return bits() * (1.0 / 4294967296.0); }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  int index(int count) { return static_cast<int>(uniform() * count); }
  bool chance(double probability) { return uniform() < probability; }

 private:
  uint32_t state_;
};

/// Footprint of one pixel on a surface, in the surface's coordinates [m]: an ellipse.
struct Footprint {
  float width_m = 0;  ///< of the short axis; finer details are averaged away
  float along_u = 0;  ///< the long axis, full length
  float along_v = 0;
  float length_m = 0;  ///< length of the long axis
};

/// Value noise on a unit lattice, within [-1, 1], smooth, about 0 on average.
float noise2(double x, double y, uint32_t seed);

/// Sum of several octaves of noise. The first one has this wavelength; each next one has half the
/// wavelength and `gain` times the strength. Octaves finer than the footprint are left out, and
/// those finer than its long axis are averaged along it: so the texture looks the same from any
/// distance. Values are between about -2 and 2, their standard deviation is about
/// 0.3 / sqrt(1 - gain^2).
struct Octaves {
  float wavelength_m;
  int count;
  float gain;
};
float texture2(double u_m, double v_m, const Footprint& footprint, const Octaves& octaves,
               uint32_t seed);
float texture3(float x_m, float y_m, float z_m, float width_m, const Octaves& octaves,
               uint32_t seed);

}  // namespace predictive_stereo::simulation
