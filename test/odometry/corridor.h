/// A corridor with textured walls, rendered by ray casting, with exact ground truth of ego-motion.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "parallel/tasks.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo::testing {

/// Smooth random texture with a mean of 128, periodic at the borders.
inline cv::Mat1f smoothTexture(cv::Size size, int seed, double blur_px, double contrast = 45) {
  cv::Mat1f noise(size), smooth;
  cv::RNG(seed).fill(noise, cv::RNG::NORMAL, 0, 1);
  cv::Mat1f padded;
  const int border = static_cast<int>(std::ceil(4 * blur_px));
  cv::copyMakeBorder(noise, padded, border, border, border, border, cv::BORDER_WRAP);
  cv::GaussianBlur(padded, padded, {}, blur_px);
  smooth = padded(cv::Rect(border, border, size.width, size.height)).clone();
  cv::Scalar mean, deviation;
  cv::meanStdDev(smooth, mean, deviation);
  return cv::Mat1f((smooth - mean[0]) * (contrast / deviation[0]) + 128);
}

class Corridor {
 public:
  explicit Corridor(int seed) {
    for (int face = 0; face < 4; ++face) {
      // Fine and coarse structure, so that there is texture at every distance.
      cv::Mat1f texture = smoothTexture({1024, 1024}, seed * 4 + face, 1.2, 25) +
                          smoothTexture({1024, 1024}, seed * 4 + face + 100, 6, 25) +
                          smoothTexture({1024, 1024}, seed * 4 + face + 200, 25, 20) - 256;
      std::vector<cv::Mat1f>& mips = mips_[face];
      mips.push_back(texture);
      while (mips.back().cols > 8) {
        cv::Mat1f half;
        cv::resize(mips.back(), half, {}, 0.5, 0.5, cv::INTER_AREA);
        mips.push_back(half);
      }
    }
  }

  /// The image of a pinhole camera (the left one of the rig if shift_m is 0, the right one if it is
  /// the baseline).
  cv::Mat1b render(const StereoRig& rig, const Eigen::Isometry3d& T_world_cam, double shift_m,
                   double noise_sigma = 0, int noise_seed = 0) const {
    cv::Mat1b image(rig.size);
    const Eigen::Vector3d centre = T_world_cam * Eigen::Vector3d(shift_m, 0, 0);
    const double cx = shift_m == 0 ? rig.cx_left_px : rig.cx_right_px;
    parallelFor({0, image.rows}, [&](const cv::Range& range) {
      for (int y = range.start; y < range.end; ++y)
        for (int x = 0; x < image.cols; ++x) {
          double sum = 0;
          for (const double dy : {-0.25, 0.25})
            for (const double dx : {-0.25, 0.25}) {
              const Eigen::Vector3d ray((x + dx - cx) / rig.fx_px, (y + dy - rig.cy_px) / rig.fy_px,
                                        1);
              sum += shade(centre, T_world_cam.linear() * ray, rig.fx_px);
            }
          image(y, x) = cv::saturate_cast<uchar>(sum / 4);
        }
    });
    if (noise_sigma > 0) {
      cv::Mat1s noise(image.size());
      cv::RNG(noise_seed).fill(noise, cv::RNG::NORMAL, 0, noise_sigma);
      cv::add(image, noise, image, cv::noArray(), CV_8U);
    }
    return image;
  }

  /// How far a ray goes, in multiples of its direction: the depth [m] if its z in the camera is 1.
  static double distance(const Eigen::Vector3d& centre, const Eigen::Vector3d& ray) {
    return hitOf(centre, ray).distance;
  }

 private:
  static constexpr double kTexelsPerMetre = 60;

  struct Hit {
    double distance = 1e9;
    int face = -1;
  };

  static Hit hitOf(const Eigen::Vector3d& centre, const Eigen::Vector3d& ray) {
    // Left and right wall, floor and ceiling.
    const double offsets[4] = {-4, 5, 1.65, -3};
    Hit hit;
    for (int i = 0; i < 4; ++i) {
      const int axis = i / 2;
      const double t = (offsets[i] - centre[axis]) / ray[axis];
      if (t > 0 && t < hit.distance) hit = {t, i};
    }
    return hit;
  }

  double shade(const Eigen::Vector3d& centre, const Eigen::Vector3d& ray, double focal_px) const {
    const auto [nearest, face] = hitOf(centre, ray);
    if (face < 0) return 128;
    const Eigen::Vector3d hit = centre + nearest * ray;
    const double across = face < 2 ? hit.y() : hit.x();
    const double footprint = nearest / focal_px * kTexelsPerMetre;
    const double level = std::clamp(std::log2(std::max(footprint, 1e-6)), 0.0,
                                    static_cast<double>(mips_[face].size() - 2));
    const int k = static_cast<int>(level);
    const double fine = sample(mips_[face][k], hit.z(), across, k);
    const double coarse = sample(mips_[face][k + 1], hit.z(), across, k + 1);
    return fine + (level - k) * (coarse - fine);
  }

  static double sample(const cv::Mat1f& mip, double along_m, double across_m, int level) {
    const double u = (along_m * kTexelsPerMetre + 0.5) / (1 << level) - 0.5;
    const double v = (across_m * kTexelsPerMetre + 0.5) / (1 << level) - 0.5;
    const int x = static_cast<int>(std::floor(u)), y = static_cast<int>(std::floor(v));
    const double fx = u - x, fy = v - y;
    const auto at = [&](int row, int column) {
      return static_cast<double>(mip(row & (mip.rows - 1), column & (mip.cols - 1)));
    };
    return (1 - fy) * ((1 - fx) * at(y, x) + fx * at(y, x + 1)) +
           fy * ((1 - fx) * at(y + 1, x) + fx * at(y + 1, x + 1));
  }

  std::vector<cv::Mat1f> mips_[4];
};

}  // namespace predictive_stereo::testing
