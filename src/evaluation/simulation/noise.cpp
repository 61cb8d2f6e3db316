#include "evaluation/simulation/noise.h"

#include <algorithm>

namespace predictive_stereo::simulation {
namespace {

constexpr uint32_t kX = 0x8da6b343U, kY = 0xd8163841U, kZ = 0xcb1ab31fU;

// A cheaper hash than mix(), because an image needs millions of lattice points.
inline float lattice(uint32_t h) {
  h ^= h >> 15;
  h *= 0x2c1b3c6dU;
  h ^= h << 13;
  return static_cast<float>(static_cast<int32_t>(h)) * (1.0f / 2147483648.0f);
}

template <class Number>
inline int floorOf(Number x) {
  const int i = static_cast<int>(x);
  return i - (x < static_cast<Number>(i));
}

inline float smooth(float f) { return f * f * (3.0f - 2.0f * f); }

// Rotation of each octave's lattice. Lattices whose axes are parallel to each other and to the
// image rows would be visible as a grid.
constexpr float kCos[4] = {0.921061f, 0.362358f, -0.665276f, 0.764842f};
constexpr float kSin[4] = {0.389418f, 0.932039f, 0.746597f, -0.644218f};

constexpr int kSamples = 3;  // at most, along a footprint

// 1 for waves longer than four footprints, 0 for those shorter than two.
inline float visibility(float wavelength, float footprint) {
  return std::clamp(0.5f * wavelength / footprint - 1.0f, 0.0f, 1.0f);
}

// Noise at (fx, fy) from a lattice point whose products with kX and kY are x0 and y0.
inline float latticeNoise(uint32_t x0, uint32_t y0, float fx, float fy) {
  const float sx = smooth(fx), sy = smooth(fy);
  const uint32_t x1 = x0 + kX, y1 = y0 + kY;
  const float a = lattice(x0 ^ y0), b = lattice(x1 ^ y0);
  const float c = lattice(x0 ^ y1), d = lattice(x1 ^ y1);
  const float top = a + (b - a) * sx, bottom = c + (d - c) * sx;
  return top + (bottom - top) * sy;
}

template <class Number>
inline float noiseAt(Number x, Number y, uint32_t seed) {
  const int ix = floorOf(x), iy = floorOf(y);
  return latticeNoise(static_cast<uint32_t>(ix) * kX + seed, static_cast<uint32_t>(iy) * kY,
                      static_cast<float>(x - static_cast<Number>(ix)),
                      static_cast<float>(y - static_cast<Number>(iy)));
}

inline float noiseAt(float x, float y, float z, uint32_t seed) {
  const int iz = floorOf(z);
  const uint32_t plane = seed + static_cast<uint32_t>(iz) * kZ;
  const float near = noiseAt(x, y, plane), far = noiseAt(x, y, plane + kZ);
  return near + (far - near) * smooth(z - static_cast<float>(iz));
}

}  // namespace

float noise2(double x, double y, uint32_t seed) { return noiseAt(x, y, seed); }

float texture2(double u_m, double v_m, const Footprint& footprint, const Octaves& octaves,
               uint32_t seed) {
  float sum = 0, amplitude = 1, wavelength = octaves.wavelength_m;
  for (int k = 0; k < octaves.count; ++k, amplitude *= octaves.gain, wavelength *= 0.5f) {
    float weight = visibility(wavelength, footprint.width_m);
    if (weight <= 0) break;
    const float scale = 1 / wavelength, c = kCos[k & 3] * scale, s = kSin[k & 3] * scale;
    const uint32_t octave = seed + 0x9e37U * static_cast<uint32_t>(k);
    const double x = u_m * c - v_m * s, y = u_m * s + v_m * c;
    const int samples = std::min(kSamples, 1 + static_cast<int>(2 * footprint.length_m * scale));
    if (samples == 1) {
      sum += amplitude * weight * noiseAt(x, y, octave);
      continue;
    }
    // With more samples along the axis the average of all details would be their mean, 0.
    if (samples == kSamples) weight *= std::min(1.0f, kSamples * wavelength / footprint.length_m);
    const float step_x = (footprint.along_u * c - footprint.along_v * s) / samples;
    const float step_y = (footprint.along_u * s + footprint.along_v * c) / samples;
    const int ix = floorOf(x), iy = floorOf(y);
    const uint32_t x0 = static_cast<uint32_t>(ix) * kX + octave,
                   y0 = static_cast<uint32_t>(iy) * kY;
    float sample_x = static_cast<float>(x - ix) - 0.5f * (samples - 1) * step_x;
    float sample_y = static_cast<float>(y - iy) - 0.5f * (samples - 1) * step_y;
    float value = 0;
    for (int i = 0; i < samples; ++i, sample_x += step_x, sample_y += step_y) {
      const int jx = floorOf(sample_x), jy = floorOf(sample_y);
      value +=
          latticeNoise(x0 + static_cast<uint32_t>(jx) * kX, y0 + static_cast<uint32_t>(jy) * kY,
                       sample_x - static_cast<float>(jx), sample_y - static_cast<float>(jy));
    }
    sum += amplitude * weight * value / static_cast<float>(samples);
  }
  return sum;
}

float texture3(float x_m, float y_m, float z_m, float width_m, const Octaves& octaves,
               uint32_t seed) {
  float sum = 0, amplitude = 1, wavelength = octaves.wavelength_m;
  for (int k = 0; k < octaves.count; ++k, amplitude *= octaves.gain, wavelength *= 0.5f) {
    const float weight = visibility(wavelength, width_m);
    if (weight <= 0) break;
    const float scale = 1 / wavelength, c = kCos[k & 3] * scale, s = kSin[k & 3] * scale;
    sum += amplitude * weight *
           noiseAt(x_m * c - y_m * s, x_m * s + y_m * c, z_m * scale,
                   seed + 0x9e37U * static_cast<uint32_t>(k));
  }
  return sum;
}

}  // namespace predictive_stereo::simulation
