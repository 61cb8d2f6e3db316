/// One image of the street: rays, light, edges, sensor.
#pragma once

#include <functional>
#include <opencv2/core.hpp>

#include "simulation/ray_grid.h"
#include "simulation/scene.h"

namespace predictive_stereo::simulation {

/// The ideal pixel whose ray a pixel of the image sees.
using RowOfPixel = std::function<float(int x, int y)>;

/// What the rays through the centres of the pixels meet.
class HitImage {
 public:
  HitImage(const RayGrid& grid, cv::Size size, const RowOfPixel& ideal_row);
  const Hit& at(int x, int y) const {
    return hits_[static_cast<size_t>(y) * static_cast<size_t>(size_.width) +
                 static_cast<size_t>(x)];
  }
  cv::Size size() const { return size_; }

 private:
  cv::Size size_;
  std::vector<Hit> hits_;
};

/// Radiance of every pixel: its centre's ray alone within surfaces, four rays at edges.
void renderRadiance(const RayGrid& grid, const HitImage& hits, const Look& look,
                    const RowOfPixel& ideal_row, uint32_t seed, cv::Mat1f& radiance);

/// Grey levels of an exposure.
struct Exposure {
  double gain = 255, offset = 0;
  double noise = 0, shot_noise = 0;
  double rain = 0;
  uint32_t seed = 0;
};
void expose(const cv::Mat1f& radiance, const Exposure& exposure, cv::Mat1b& image);

}  // namespace predictive_stereo::simulation
