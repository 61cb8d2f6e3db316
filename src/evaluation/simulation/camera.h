/// Rendering of one image: ray casting, shading, antialiasing, sensor model.
#pragma once

#include <functional>
#include <opencv2/core.hpp>

#include "evaluation/simulation/rays.h"
#include "evaluation/simulation/scene.h"

namespace predictive_stereo::simulation {

/// Row of the perfectly aligned image that corresponds to a pixel of the image.
using RowOfPixel = std::function<float(int x, int y)>;

/// Light sources and reflections.
struct Light {
  const Look& look;
  const Shadows& shadows;
  uint32_t sky_seed;
};

/// First hits of the rays through the pixel centres, and whether the sun shines on them.
struct HitImage {
  explicit HitImage(cv::Size image_size)
      : size(image_size), hits(static_cast<size_t>(size.area())) {}
  Hit& at(int x, int y) { return hits[static_cast<size_t>(y * size.width + x)]; }
  const Hit& at(int x, int y) const { return hits[static_cast<size_t>(y * size.width + x)]; }

  cv::Size size;
  std::vector<Hit> hits;
};

/// Adds the radiance of every pixel of one camera: from the ray through its centre inside surfaces,
/// from four rays at edges.
/// @param radiance  initialized; its size is that of the image.
HitImage addRadiance(const RayGrid& grid, const Light& light, const RowOfPixel& ideal_row,
                     cv::Mat1f& radiance);

/// Grey levels of an exposure: gain * radiance + offset, with noise and rain.
void expose(const cv::Mat1f& radiance, const Sensor& sensor, double gain, double offset,
            uint32_t seed, cv::Mat1b& image);

}  // namespace predictive_stereo::simulation
