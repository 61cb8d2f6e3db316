#include "evaluation/simulation/material.h"

#include <algorithm>
#include <cmath>

#include "evaluation/simulation/worlds.h"

namespace predictive_stereo::simulation {
namespace {

// 1 if x is in [low, high], else 0; blurred over the footprint.
float band(double x, double low, double high, float blur) {
  const float width = std::max(blur, 1e-3f);
  const auto step = [width](double distance) {
    return std::clamp(static_cast<float>(distance) / width + 0.5f, 0.0f, 1.0f);
  };
  return step(x - low) * step(high - x);
}

double remainder(double x, double period) { return x - period * std::floor(x / period); }

// Contrast of a detail of this size: 1, or less if the footprint is not much smaller.
float fade(float detail_m, float footprint_m) {
  return std::clamp(detail_m / footprint_m - 0.5f, 0.0f, 1.0f);
}

// Bricks or pavers of random brightness between darker joints.
float masonry(double u, double v, float length, float height, float joint, const Footprint& fp,
              uint32_t seed) {
  const float blur_v = fp.width_m + std::abs(fp.along_v),
              blur_u = fp.width_m + std::abs(fp.along_u);
  const int row = static_cast<int>(std::floor(v / height));
  const double shifted = u + (row & 1 ? 0.5 * length : 0.0);
  const int column = static_cast<int>(std::floor(shifted / length));
  const float stone =
      static_cast<float>(hashOf(seed, static_cast<uint32_t>(row), static_cast<uint32_t>(column))) *
          (2.0f / 4294967296.0f) -
      1.0f;
  const float in_v = band(v - row * static_cast<double>(height), joint, height - joint, blur_v);
  const float in_u =
      band(shifted - column * static_cast<double>(length), joint, length - joint, blur_u);
  const float stones = fade(height, blur_v) * fade(length, blur_u);
  const float joints = in_v * in_u - 1.0f;
  return stones * (0.17f * stone + 0.28f * joints);
}

float roadAlbedo(double x, double y, const Footprint& fp, float contrast) {
  const float grain = texture2(x, y, fp, {0.07f, 3, 0.9f}, 11);
  const float patches = texture2(x, y, fp, {4.0f, 5, 0.62f}, 12);
  // Tar seams: thin dark lines where a slow noise passes through zero.
  const float seam_width = 0.03f + fp.width_m + 0.3f * fp.length_m;
  const float seam = std::abs(noise2(x / 3.1, y / 2.3, 13)) * 1.5f;
  const float crack = std::max(0.0f, 1.0f - seam / seam_width) * fade(0.05f, 0.5f * seam_width);
  float albedo = 0.30f + contrast * (0.11f * grain + 0.045f * patches - 0.12f * crack);
  const Marking marking = markingAt(x, y);
  if (marking.strength > 0) {
    const float blur = fp.width_m + 0.5f * (std::abs(marking.across_u ? fp.along_u : fp.along_v));
    const float paint = std::clamp(marking.inside_m / std::max(blur, 1e-3f) + 0.5f, 0.0f, 1.0f);
    if (paint > 0) {
      const float worn = 0.85f + 0.25f * texture2(x, y, fp, {0.5f, 4, 0.8f}, 14);
      albedo += paint * marking.strength * worn * 0.5f;
    }
  }
  return albedo;
}

Material materialOf(const Primitive& p, int part) {
  return part >= kPane && part < kReveal ? kGlass : p.material;
}

float plateAlbedo(const Primitive& p, const Surface& s, const Footprint& fp) {
  // Dark strokes on a bright plate, like letters.
  const float blur = fp.width_m + fp.length_m;
  const float cell = std::max(0.06f, 0.35f * p.half_m.z());
  const float letters = noise2(s.u_m / cell, s.v_m / (1.7 * cell), p.seed);
  const float stroke = std::clamp((letters - 0.15f) * cell / blur + 0.5f, 0.0f, 1.0f);
  return p.albedo * (1.0f - 0.75f * stroke * fade(cell, blur));
}

// Whether a point of a cabin is on a window: these are above the belt line and between the pillars.
bool isWindow(const Primitive& p, int part, const Vector3f& local) {
  if (part >= 4) return false;
  const float height = local.z() / p.half_m.z();
  const float along = part < 2 ? local.y() / p.half_m.y() : local.x() / p.half_m.x();
  const float slope = part < 2 ? 0.0f : 0.25f * (height + 1);
  const bool pillar =
      std::abs(along) > 0.9f - slope || (part >= 2 && std::abs(along + 0.08f) < 0.035f);
  return height >= -0.75f && height <= 0.82f && !pillar;
}

// A heading, lines of text and pictures.
float printAlbedo(const Primitive& p, const Surface& s, const Footprint& fp, float contrast,
                  uint32_t seed) {
  const float blur = fp.width_m + fp.length_m;
  const int column = static_cast<int>(std::floor(s.u_m / 0.23)),
            row = static_cast<int>(std::floor(s.v_m / 0.17));
  const uint32_t block = hashOf(seed, static_cast<uint32_t>(column), static_cast<uint32_t>(row));
  if (block % 3 == 0)  // a picture
    return p.albedo *
           (0.6f + contrast * 0.45f * texture2(s.u_m, s.v_m, fp, {0.12f, 5, 0.8f}, block));
  const float words = noise2(s.u_m / 0.018, std::floor(s.v_m / 0.02), block);
  const float line = band(remainder(s.v_m, 0.02), 0.006, 0.016, blur);
  const float ink = std::clamp((words + 0.35f) * 0.018f / blur + 0.5f, 0.0f, 1.0f) * line;
  const float seen = fade(0.012f, blur);
  return p.albedo * (1.0f - contrast * 0.7f * (seen * ink + (1 - seen) * 0.35f));
}

float chessboardAlbedo(const Primitive& p, const Surface& s, const Footprint& fp) {
  constexpr float kSquare_m = 0.1f, kBorder_m = 0.05f;
  const float blur = fp.width_m + fp.length_m;
  // A square wave of -1 and 1, blurred at the edges.
  const auto wave = [blur](double x, float half) {
    const double from_edge = (x + half - kBorder_m) / kSquare_m;
    const double last = std::round(2 * (half - kBorder_m) / kSquare_m) - 1;
    const double nearest = std::clamp(std::round(from_edge), 1.0, last);
    const auto beyond = static_cast<float>((from_edge - nearest) * kSquare_m);
    const float side = static_cast<int>(nearest) & 1 ? -1.0f : 1.0f;
    return side * std::clamp(2 * beyond / blur, -1.0f, 1.0f);
  };
  const float inside = band(s.u_m, kBorder_m - p.half_m.x(), p.half_m.x() - kBorder_m, blur) *
                       band(s.v_m, kBorder_m - p.half_m.y(), p.half_m.y() - kBorder_m, blur);
  const float product = wave(s.u_m, p.half_m.x()) * wave(s.v_m, p.half_m.y());
  return p.albedo * (1 - inside * (0.47f + 0.47f * product));
}

// Slabs between a kerb and the grass of a block.
float pavementAlbedo(const Primitive& p, int part, const Surface& s, const Vector3f& local,
                     const Footprint& fp, float contrast, uint32_t seed) {
  if (part < 4) return 0.42f + contrast * 0.12f * texture2(s.u_m, s.v_m, fp, {0.8f, 6, 0.8f}, seed);
  const float inside = p.half_m.x() - std::max(std::abs(local.x()), std::abs(local.y()));
  const float kerb = band(inside, 0.0, 0.14, fp.width_m);
  const float edge = band(inside, -1.0, kSidewalk_m, fp.width_m);
  float albedo = 0;
  if (edge > 0)
    albedo += edge * (0.40f + 0.22f * kerb +
                      contrast * (masonry(s.u_m, s.v_m, 0.4f, 0.4f, 0.012f, fp, seed) +
                                  0.06f * texture2(s.u_m, s.v_m, fp, {2.0f, 6, 0.85f}, seed)));
  if (edge < 1)  // grass behind
    albedo += (1 - edge) *
              (0.24f + contrast * (0.10f * texture2(s.u_m, s.v_m, fp, {0.5f, 6, 0.95f}, seed) +
                                   0.05f * texture2(s.u_m, s.v_m, fp, {8.0f, 3, 0.7f}, seed + 1)));
  return albedo;
}

float paintAlbedo(const Primitive& p, const Surface& s, const Footprint& fp, float contrast,
                  uint32_t seed) {
  const float dirt = texture2(s.u_m, s.v_m, fp, {0.7f, 5, 0.75f}, seed);
  // Gaps between doors and bonnet.
  const float gap = band(remainder(s.u_m + 0.45, 1.05), 0.0, 0.012, fp.width_m + fp.length_m) *
                    fade(0.02f, fp.width_m + fp.length_m);
  return p.albedo * (1.0f + contrast * (0.13f * dirt - 0.7f * gap));
}

float cabinAlbedo(const Primitive& p, int part, const Surface& s, const Vector3f& local,
                  const Footprint& fp, float contrast, uint32_t seed) {
  const bool roof = part >= 4;
  if (roof || !isWindow(p, part, local))
    return p.albedo * (1.0f + contrast * 0.1f * texture2(s.u_m, s.v_m, fp, {0.7f, 5, 0.7f}, seed));
  return 0.07f + contrast * 0.05f * texture2(s.u_m, s.v_m, fp, {0.4f, 3, 0.7f}, seed);
}

float rubberAlbedo(const Primitive& p, int part, const Surface& s, const Footprint& fp,
                   float contrast, uint32_t seed) {
  const float radius = static_cast<float>(std::hypot(s.u_m, s.v_m));
  const bool rim = part >= 4 && radius < 0.65f * p.half_m.x();
  const float spokes =
      rim ? 0.3f + 0.25f * noise2(std::atan2(s.v_m, s.u_m) * 2.0, radius * 9, seed) : 0.06f;
  return spokes + contrast * 0.04f * texture2(s.u_m, s.v_m, fp, {0.2f, 4, 0.8f}, seed);
}

float linoleumAlbedo(const Primitive& p, const Surface& s, const Footprint& fp, float contrast,
                     uint32_t seed) {
  const float speckles = texture2(s.u_m, s.v_m, fp, {0.03f, 3, 0.8f}, seed);
  const float stains = texture2(s.u_m, s.v_m, fp, {1.5f, 4, 0.6f}, seed + 1);
  const float blur = fp.width_m + fp.length_m;
  const float seam = band(remainder(s.v_m, 2.0), 0.0, 0.006, blur) * fade(0.006f, 0.5f * blur);
  return p.albedo + contrast * (0.06f * speckles + 0.03f * stains - 0.15f * seam);
}

}  // namespace

float albedoOf(const Primitive& p, int part, const Surface& s, const Vector3f& local,
               const Footprint& fp, float scene_contrast) {
  const float contrast = scene_contrast * p.contrast;
  const double u = s.u_m, v = s.v_m;
  const uint32_t seed = p.seed + static_cast<uint32_t>(part) * 977U;
  const auto solid = [&](const Octaves& octaves) {
    return texture3(local.x(), local.y(), local.z(), fp.width_m, octaves, p.seed);
  };
  switch (materialOf(p, part)) {
    case kRoad:
      return roadAlbedo(u, v, fp, contrast);
    case kPavement:
      return pavementAlbedo(p, part, s, local, fp, contrast, seed);
    case kPlaster: {
      const float stains = texture2(u, v, fp, {4.0f, 6, 0.75f}, seed);
      const float streaks = texture2(u * 3, v * 0.25, fp, {0.7f, 4, 0.8f}, seed + 1);
      return p.albedo + contrast * (0.045f * stains + 0.04f * streaks);
    }
    case kBrick:
      return p.albedo + contrast * (0.7f * masonry(u, v, 0.50f, 0.24f, 0.012f, fp, seed) +
                                    0.06f * texture2(u, v, fp, {3.0f, 7, 0.8f}, seed));
    case kRoof:
      return p.albedo + contrast * (0.8f * masonry(u, v, 0.3f, 0.35f, 0.03f, fp, seed) +
                                    0.04f * texture2(u, v, fp, {3.0f, 5, 0.8f}, seed));
    case kGlass:
      // Curtains and dark rooms.
      return 0.10f + contrast * 0.08f * texture2(u, v, fp, {0.7f, 4, 0.7f}, seed);
    case kLeaves:
      return p.albedo * (1.0f + contrast * 0.75f * texture2(u, v, fp, {0.4f, 4, 0.95f}, seed));
    case kBark:
      return p.albedo *
             (1.0f + contrast * 0.6f * texture2(u * 3, v * 0.7, fp, {0.5f, 6, 0.85f}, seed));
    case kPaint:
      return paintAlbedo(p, s, fp, contrast, seed);
    case kCabin:
      return cabinAlbedo(p, part, s, local, fp, contrast, seed);
    case kRubber:
      return rubberAlbedo(p, part, s, fp, contrast, seed);
    case kCloth:
      return p.albedo * (1.0f + contrast * 0.45f * solid({0.3f, 4, 0.8f}));
    case kSkin:
      return p.albedo * (1.0f + contrast * 0.25f * solid({0.15f, 3, 0.8f}));
    case kLamp:
    case kMetal:
      return p.albedo * (1.0f + contrast * 0.3f * texture2(u, v, fp, {0.6f, 6, 0.75f}, seed));
    case kSign:
      return plateAlbedo(p, s, fp);
    case kLinoleum:
      return linoleumAlbedo(p, s, fp, contrast, seed);
    case kPanels:
      return p.albedo + contrast * (0.35f * masonry(u, v, 0.6f, 0.6f, 0.008f, fp, seed) +
                                    0.05f * texture2(u, v, fp, {0.04f, 3, 0.9f}, seed));
    case kPrint:
      return printAlbedo(p, s, fp, contrast, seed);
    case kChessboard:
      return chessboardAlbedo(p, s, fp);
  }
  return 0;
}

float lampLight(const CeilingLamps& lamps, const Vector3f& point, const Vector3f& normal) {
  if (lamps.pitch_m <= 0 || point.z() >= lamps.height_m) return 0;
  constexpr int kReach = 2;  // the light of lamps farther away is negligible
  const float reach2 = lamps.pitch_m * lamps.pitch_m * (kReach - 0.5f) * (kReach - 0.5f);
  const float column = std::round(point.x() / lamps.pitch_m),
              row = std::round(point.y() / lamps.pitch_m);
  float sum = 0;
  for (int i = -kReach; i <= kReach; ++i)
    for (int j = -kReach; j <= kReach; ++j) {
      const Vector3f to_lamp((column + static_cast<float>(i)) * lamps.pitch_m - point.x(),
                             (row + static_cast<float>(j)) * lamps.pitch_m - point.y(),
                             lamps.height_m - point.z());
      const float aside2 = to_lamp.head<2>().squaredNorm(), facing = normal.dot(to_lamp);
      if (aside2 >= reach2 || facing <= 0) continue;
      const float near = 1 - aside2 / reach2, distance2 = to_lamp.squaredNorm() + 0.05f;
      // Cosines of both surfaces over the squared distance (Lambert).
      sum += near * near * facing * to_lamp.z() / (distance2 * distance2);
    }
  return lamps.strength * sum;
}

float mirrorOf(const Primitive& p, int part, const Vector3f& local) {
  const Material material = materialOf(p, part);
  if (material == kGlass) return 0.35f;
  if (material == kPaint) return 0.12f;
  if (material == kCabin) return isWindow(p, part, local) ? 0.45f : 0.12f;
  return 0;
}

float surroundings(const Vector3f& direction, const Look& look, uint32_t seed) {
  const float azimuth = std::atan2(direction.y(), direction.x());
  // The roofs across the street against the sky.
  const float roofs = 0.25f + 0.2f * noise2(azimuth * 3, 0.5, seed);
  const float detail = noise2(azimuth * 7, direction.z() * 7, seed + 1);
  const float street = look.ambient * (0.75f + 0.6f * detail);
  const float above = std::clamp((direction.z() - roofs) * 12 + 0.5f, 0.0f, 1.0f);
  return street + above * (look.sky - street);
}

float skyRadiance(const Vector3f& direction, float pixel_per_m, const Look& look, uint32_t seed) {
  const Vector3f unit = direction.normalized();
  const float height = std::max(unit.z(), 0.02f);
  Footprint footprint;
  footprint.width_m = pixel_per_m;
  const float clouds = texture2(std::atan2(unit.y(), unit.x()) * 2.0, std::log(height) * 0.7,
                                footprint, {0.5f, 5, 0.6f}, seed);
  return look.sky * (1.0f - 0.25f * height + 0.16f * clouds);
}

}  // namespace predictive_stereo::simulation
