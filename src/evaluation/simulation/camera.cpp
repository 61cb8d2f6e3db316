#include "evaluation/simulation/camera.h"

#include <algorithm>
#include <cmath>

#include "parallel/tasks.h"

namespace predictive_stereo::simulation {
namespace {

// Footprint of a pixel on a flat surface: an ellipse, which is longer for grazing views.
Footprint footprintOf(const Surface& surface, const Vector3f& direction, float width_m) {
  Footprint footprint;
  footprint.width_m = width_m;
  if (surface.axis_u.isZero()) return footprint;
  const float slope = std::abs(surface.normal.dot(direction)) / direction.norm();
  const float stretch = std::min(1.0f / std::max(slope, 1e-3f), 60.0f);
  if (stretch < 1.3f) return footprint;
  const float u = surface.axis_u.dot(direction), v = surface.axis_v.dot(direction);
  const float norm = std::sqrt(u * u + v * v);
  if (norm <= 0) return footprint;
  footprint.length_m = stretch * footprint.width_m;
  footprint.along_u = footprint.length_m * u / norm;
  footprint.along_v = footprint.length_m * v / norm;
  return footprint;
}

struct Shader {
  const RayGrid& grid;
  const Light& light;
  const Vector3f offset_m;  // of the camera from the centre of light.shadows, world axes

  Shader(const RayGrid& g, const Light& l)
      : grid(g), light(l), offset_m((g.centre_m() - l.shadows.centre_m()).cast<float>()) {}

  // Casts a ray, and a shadow ray from its hit.
  Hit cast(float x, float y) const {
    Hit lit = grid.cast(x, y);
    if (lit.sky() || light.look.sun <= 0) return lit;
    const Primitive& p = grid.primitive(lit.primitive);
    const Vector3f direction = grid.directionOf(x, y);
    const Vector3f local_direction = p.R_local_world * direction;
    const Surface surface =
        surfaceAt(p, lit.part, grid.originIn(lit.primitive) + lit.t * local_direction);
    const float facing = surface.normal.dot(p.R_local_world * light.look.to_sun) *
                         (surface.normal.dot(local_direction) > 0 ? -1.0f : 1.0f);
    lit.sunny = facing > 0 && light.shadows.sunReaches(offset_m + lit.t * direction);
    return lit;
  }

  // @param normal  towards the viewer.
  float illuminationOf(const Hit& hit, const Vector3f& direction, const Vector3f& normal) const {
    const Look& look = light.look;
    float illumination = look.ambient * (0.75f + 0.25f * normal.z());
    if (hit.sunny) illumination += look.sun * std::abs(normal.dot(look.to_sun));
    if (look.headlights > 0) {
      const float below = std::clamp(0.6f - 8 * direction.z(), 0.12f, 1.0f);
      illumination += below * look.headlights / (1 + 0.006f * hit.t * hit.t);
    }
    if (look.ceiling.pitch_m > 0)
      illumination +=
          lampLight(look.ceiling, grid.centre_m().cast<float>() + hit.t * direction, normal);
    return illumination;
  }

  float operator()(const Hit& hit, float x, float y) const {
    const Look& look = light.look;
    const uint32_t seed = light.sky_seed;
    const Vector3f direction = grid.directionOf(x, y);
    if (hit.sky()) return skyRadiance(direction, grid.pixelPerM(), look, seed);
    const Primitive& p = grid.primitive(hit.primitive);
    const Vector3f local_direction = p.R_local_world * direction;
    const Vector3f point = grid.originIn(hit.primitive) + hit.t * local_direction;
    Surface surface = surfaceAt(p, hit.part, point);
    if (surface.normal.dot(local_direction) > 0) surface.normal = -surface.normal;
    if (p.shape == Shape::kGround) {
      // Texture coordinates are double because the town is unbounded.
      surface.u_m = p.centre_m.x() + point.x();
      surface.v_m = p.centre_m.y() + point.y();
    }
    const Footprint footprint = footprintOf(surface, local_direction, hit.t * grid.pixelPerM());
    const float albedo =
        std::clamp(albedoOf(p, hit.part, surface, point, footprint, look.contrast), 0.01f, 1.0f);
    const Vector3f normal = p.R_local_world.transpose() * surface.normal;
    float radiance = albedo * illuminationOf(hit, direction, normal);
    if (p.material == kLamp) radiance += look.lamps;
    const float mirror = look.reflections * mirrorOf(p, hit.part, point);
    if (mirror > 0) {
      const Vector3f view = direction.normalized();
      const float cosine = std::min(1.0f, -normal.dot(view));
      const float share = mirror + (1 - mirror) * std::pow(1 - cosine, 5.0f) * 0.5f;
      radiance += share * surroundings(view + 2 * cosine * normal, look, seed);
    }
    return radiance;
  }
};

bool sameSurface(const Hit& a, const Hit& b) {
  return a.primitive == b.primitive && a.part == b.part && a.sunny == b.sunny;
}

bool isEdge(const HitImage& hits, int x, int y) {
  const int left = std::max(x - 1, 0), right = std::min(x + 1, hits.size.width - 1);
  const int bottom = std::min(y + 1, hits.size.height - 1);
  const Hit& centre = hits.at(x, y);
  for (int row = std::max(y - 1, 0); row <= bottom; ++row)
    for (int column = left; column <= right; ++column)
      if (!sameSurface(hits.at(column, row), centre)) return true;
  return false;
}

// Streaks of drops near the camera: brighter than the background, different in each image.
void addRain(double per_megapixel, uint32_t seed, cv::Mat1b& image) {
  Random random(seed);
  const int streaks = static_cast<int>(per_megapixel * 1e-6 * static_cast<double>(image.total()));
  for (int i = 0; i < streaks; ++i) {
    double x = random.uniform(0, image.cols);
    const int top = static_cast<int>(random.uniform(-0.1, 1) * image.rows);
    const int length = static_cast<int>(random.uniform(0.02, 0.12) * image.rows) + 2;
    const double slant = random.uniform(0.02, 0.15), light = random.uniform(12, 60);
    for (int y = top; y < top + length; ++y, x += slant) {
      const int column = static_cast<int>(x);
      if (y < 0 || y >= image.rows || column >= image.cols) continue;
      image(y, column) = cv::saturate_cast<uchar>(image(y, column) + light);
    }
  }
}

}  // namespace

HitImage addRadiance(const RayGrid& grid, const Light& light, const RowOfPixel& ideal_row,
                     cv::Mat1f& radiance) {
  const cv::Size size = radiance.size();
  const Shader shade(grid, light);
  HitImage hits(size);
  parallelForEach(size.height, [&](int y) {
    for (int x = 0; x < size.width; ++x)
      hits.at(x, y) = shade.cast(static_cast<float>(x), ideal_row(x, y));
  });
  // A rotated grid of four rays.
  constexpr float kAcross[4] = {-0.125f, 0.375f, -0.375f, 0.125f};
  constexpr float kDown[4] = {-0.375f, -0.125f, 0.125f, 0.375f};
  parallelForEach(size.height, [&](int y) {
    for (int x = 0; x < size.width; ++x) {
      const float row = ideal_row(x, y);
      if (!isEdge(hits, x, y)) {
        radiance(y, x) += shade(hits.at(x, y), static_cast<float>(x), row);
        continue;
      }
      // A primitive that several of them hit is lit and shaded once.
      Hit met[4];
      float radiance_of[4], sum = 0;
      for (int i = 0; i < 4; ++i) {
        const float ray_x = static_cast<float>(x) + kAcross[i], ray_y = row + kDown[i];
        met[i] = shade.cast(ray_x, ray_y);
        int j = 0;
        while (!sameSurface(met[j], met[i])) ++j;
        radiance_of[i] = j < i ? radiance_of[j] : shade(met[i], ray_x, ray_y);
        sum += radiance_of[i];
      }
      radiance(y, x) += 0.25f * sum;
    }
  });
  return hits;
}

void expose(const cv::Mat1f& radiance, const Sensor& sensor, double gain, double offset,
            uint32_t seed, cv::Mat1b& image) {
  image.create(radiance.size());
  const auto floor = static_cast<float>(sensor.noise * sensor.noise);
  const auto shot = static_cast<float>(sensor.shot_noise);
  parallelForEach(image.rows, [&](int y) {
    for (int x = 0; x < image.cols; ++x) {
      const float level = static_cast<float>(gain) * radiance(y, x) + static_cast<float>(offset);
      // The sum of four bytes is nearly normal; its variance is 4 (256^2 - 1) / 12.
      const uint32_t bits = hashOf(seed, static_cast<uint32_t>(y), static_cast<uint32_t>(x));
      const auto sum =
          static_cast<float>((bits & 255) + (bits >> 8 & 255) + (bits >> 16 & 255) + (bits >> 24));
      const float normal = (sum - 510.0f) * (1.0f / 147.8f);
      const float sigma = std::sqrt(floor + shot * std::max(level, 0.0f));
      image(y, x) = cv::saturate_cast<uchar>(level + sigma * normal);
    }
  });
  addRain(sensor.rain, hashOf(seed, 1), image);
}

}  // namespace predictive_stereo::simulation
