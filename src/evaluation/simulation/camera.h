/// Rendering of one image: ray casting, shading, antialiasing, sensor model.
#pragma once

#include <functional>
#include <opencv2/core.hpp>

#include "evaluation/simulation/rays.h"
#include "evaluation/simulation/scene.h"

namespace predictive_stereo::simulation {

/// Row of the perfectly aligned image that corresponds to a pixel of the image.
using RowOfPixel = std::function<float(int x, int y)>;

/// Light sources and reflections for one camera.
struct Light {
  const Look& look;
  const RayMap& around;      ///< what casts shadows, and what glossy paint reflects
  Eigen::Vector3f offset_m;  ///< of the camera from the centre of `around`, world axes
  uint32_t sky_seed;
  Eigen::Vector3f camera_m;  ///< in the world; for ceiling lamps
};

struct LitHit : Hit {
  bool sunny = false;
};

/// First hits of the rays through the pixel centres, and whether the sun shines on them.
class HitImage {
 public:
  HitImage(const RayGrid& grid, const Light& light, cv::Size size, const RowOfPixel& ideal_row);
  const LitHit& at(int x, int y) const {
    return hits_[static_cast<size_t>(y) * static_cast<size_t>(size_.width) +
                 static_cast<size_t>(x)];
  }
  cv::Size size() const { return size_; }

 private:
  cv::Size size_;
  std::vector<LitHit> hits_;
};

/// Radiance of every pixel: from the ray through its centre inside surfaces, from four rays at
/// edges.
void renderRadiance(const RayGrid& grid, const HitImage& hits, const Light& light,
                    const RowOfPixel& ideal_row, cv::Mat1f& radiance);

/// Grey levels of an exposure.
struct Exposure {
  double gain = 255, offset = 0;
  double noise = 0, shot_noise = 0;
  double rain = 0;
  uint32_t seed = 0;
};
void expose(const cv::Mat1f& radiance, const Exposure& exposure, cv::Mat1b& image);

}  // namespace predictive_stereo::simulation
