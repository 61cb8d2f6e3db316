#include "simulation/noise.h"

#include <algorithm>
#include <cmath>

namespace predictive_stereo::simulation {
namespace {

constexpr uint32_t kX = 0x8da6b343U, kY = 0xd8163841U, kZ = 0xcb1ab31fU;

// A cheaper hash than mix(): millions of lattice points per image.
inline float lattice(uint32_t h) {
  h ^= h >> 15;
  h *= 0x2c1b3c6dU;
  h ^= h >> 12;
  h *= 0x297a2d39U;
  return static_cast<float>(static_cast<int32_t>(h)) * (1.0f / 2147483648.0f);
}

inline int floorOf(double x) {
  const int i = static_cast<int>(x);
  return i - (x < i);
}

inline float smooth(float f) { return f * f * (3.0f - 2.0f * f); }

// Each octave's lattice is turned by its own angle: lattices that share their axes with each other
// and with image rows show as a grid.
constexpr float kCos[4] = {0.921061f, 0.362358f, -0.665276f, 0.764842f};
constexpr float kSin[4] = {0.389418f, 0.932039f, 0.746597f, -0.644218f};

// 1 for waves longer than four footprints, 0 for those shorter than two.
inline float visibility(float wavelength, float footprint) {
  return std::clamp(0.5f * wavelength / footprint - 1.0f, 0.0f, 1.0f);
}

}  // namespace

float noise2(double x, double y, uint32_t seed) {
  const int ix = floorOf(x), iy = floorOf(y);
  const float fx = smooth(static_cast<float>(x - ix)), fy = smooth(static_cast<float>(y - iy));
  const uint32_t x0 = static_cast<uint32_t>(ix) * kX + seed, x1 = x0 + kX;
  const uint32_t y0 = static_cast<uint32_t>(iy) * kY, y1 = y0 + kY;
  const float a = lattice(x0 ^ y0), b = lattice(x1 ^ y0);
  const float c = lattice(x0 ^ y1), d = lattice(x1 ^ y1);
  const float top = a + (b - a) * fx, bottom = c + (d - c) * fx;
  return top + (bottom - top) * fy;
}

float noise3(float x, float y, float z, uint32_t seed) {
  const int iz = floorOf(z);
  const float fz = smooth(z - static_cast<float>(iz));
  const uint32_t plane = seed + static_cast<uint32_t>(iz) * kZ;
  const float near = noise2(x, y, plane);
  return near + (noise2(x, y, plane + kZ) - near) * fz;
}

float texture2(double u_m, double v_m, const Footprint& footprint, const Octaves& octaves,
               uint32_t seed) {
  float sum = 0, amplitude = 1, wavelength = octaves.wavelength_m;
  for (int k = 0; k < octaves.count; ++k, amplitude *= octaves.gain, wavelength *= 0.5f) {
    float weight = visibility(wavelength, footprint.width_m);
    if (weight <= 0) break;
    const double scale = 1.0 / wavelength;
    const float c = kCos[k & 3], s = kSin[k & 3];
    const int samples =
        std::clamp(static_cast<int>(2 * footprint.length_m / wavelength + 0.999f), 1, 4);
    // Beyond four samples along the axis the average of so many details is their mean, 0.
    if (samples == 4)
      weight *= std::min(1.0f, 4 * wavelength / std::max(footprint.length_m, 1e-6f));
    float value = 0;
    for (int i = 0; i < samples; ++i) {
      const float along = (i + 0.5f) / samples - 0.5f;
      const double u = u_m + along * footprint.along_u, v = v_m + along * footprint.along_v;
      value += noise2((u * c - v * s) * scale, (u * s + v * c) * scale, seed + 0x9e37U * k);
    }
    sum += amplitude * weight * value / samples;
  }
  return sum;
}

float texture3(float x_m, float y_m, float z_m, float width_m, const Octaves& octaves,
               uint32_t seed) {
  float sum = 0, amplitude = 1, wavelength = octaves.wavelength_m;
  for (int k = 0; k < octaves.count; ++k, amplitude *= octaves.gain, wavelength *= 0.5f) {
    const float weight = visibility(wavelength, width_m);
    if (weight <= 0) break;
    const float scale = 1.0f / wavelength, c = kCos[k & 3], s = kSin[k & 3];
    sum += amplitude * weight *
           noise3((x_m * c - y_m * s) * scale, (x_m * s + y_m * c) * scale, z_m * scale,
                  seed + 0x9e37U * k);
  }
  return sum;
}

}  // namespace predictive_stereo::simulation
