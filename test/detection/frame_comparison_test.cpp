/// compareFrames is bit-identical to a plain reference, on every SIMD target.
#include "detection/frame_comparison.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "every_target.h"

namespace predictive_stereo {
namespace {

constexpr float kNearest = 0.5f;

// Two frames of noise, a moving camera, and disparities with holes.
struct Frames {
  explicit Frames(cv::Size size) {
    cv::RNG rng(size.width * 1000 + size.height);
    rig.size = size;
    rig.fx_px = rig.fy_px = 0.6 * size.width;
    rig.cx_left_px = rig.cx_right_px = 0.5 * size.width;
    rig.cy_px = 0.5 * size.height;
    rig.baseline_m = 0.5;
    T_prev_cam.translation() = Eigen::Vector3d(0.02, -0.01, 0.8);
    T_prev_cam.linear() =
        Eigen::AngleAxisd(0.02, Eigen::Vector3d(0.3, 1, 0.2).normalized()).toRotationMatrix();
    const auto image = [&](ImagePyramid& pyramid) {
      cv::Mat1b grey(size);
      rng.fill(grey, cv::RNG::UNIFORM, 0, 256);
      cv::GaussianBlur(grey, grey, {5, 5}, 1.5);
      pyramid.build(grey, 2);
    };
    image(current);
    image(previous);
    // Maps are parts of larger ones, as in the nodelets.
    const auto map = [&](double low, double high) {
      cv::Mat1f larger(size.height + 3, size.width + 5);
      rng.fill(larger, cv::RNG::UNIFORM, low, high);
      return cv::Mat1f(larger(cv::Rect(cv::Point(2, 1), size)));
    };
    const cv::Mat1f noise = map(-1, 1);
    disparity_px = map(-1.2, 1.2);
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; ++x) {
        float& d = disparity_px(y, x);
        const float surface = 2 + 20.0f * static_cast<float>(y) / static_cast<float>(size.height);
        d = rng.uniform(0, 12) == 0 ? -1.0f : std::max(surface + d + noise(y, x), 0.0f);
      }
  }

  // Rows are apart in memory, as those of a part of a map.
  cv::Mat1f lattice_px() const {
    const cv::Size lattice = current.level(1).size();
    cv::Mat1f points = cv::Mat1f(lattice + cv::Size(7, 0)).colRange(3, 3 + lattice.width);
    for (int v = 0; v < points.rows; ++v)
      for (int u = 0; u < points.cols; ++u)
        points(v, u) = std::max(disparity_px(2 * v, 2 * u), 0.0f);
    return points;
  }

  StereoRig rig;
  Eigen::Isometry3d T_prev_cam = Eigen::Isometry3d::Identity();
  ImagePyramid current, previous;
  cv::Mat1f disparity_px;
};

// (x, y, d) in the previous frame; d < 0: unknown.
cv::Mat3f sources(const Frames& frames, const SourceOf& source_of) {
  const cv::Size size = frames.current.level(1).size();
  cv::Mat3f result(size, cv::Vec3f(0, 0, -1));
  for (int v = 0; v < size.height; ++v)
    for (int u = 0; u < size.width; ++u) {
      const float d = frames.disparity_px(2 * v, 2 * u);
      if (d < kNearest) continue;
      const Eigen::Vector3f at = source_of(static_cast<float>(2 * u), static_cast<float>(2 * v), d);
      const float x = 0.5f * at.x(), y = 0.5f * at.y();
      if (x >= 0 && y >= 0 && x < static_cast<float>(size.width - 1) &&
          y < static_cast<float>(size.height - 1) && at.z() > 0)
        result(v, u) = {at.x(), at.y(), at.z()};
    }
  return result;
}

float sumAround(const cv::Mat1f& map, int v, int u) {
  const auto value = [&](int y, int x) {
    return x < 0 || y < 0 || x >= map.cols || y >= map.rows ? 0.0f : map(y, x);
  };
  float column[5], sum = 0;
  for (int i = 0; i < 5; ++i) {
    column[i] = value(v - 2, u + i - 2);
    for (int j = 1; j < 5; ++j) column[i] += value(v + j - 2, u + i - 2);
    sum = i == 0 ? column[0] : sum + column[i];
  }
  return sum;
}

cv::Mat1f mismatch(const Frames& frames, const SourceOf& source_of, cv::Rect area) {
  const cv::Mat3f source = sources(frames, source_of);
  const cv::Mat1b &now = frames.current.level(1), &before = frames.previous.level(1);
  cv::Mat1f difference(area.size(), 0), known(area.size(), 0), deviation(area.size(), 0),
      result(area.size(), kUnknownMismatch);
  for (int v = 0; v < area.height; ++v)
    for (int u = 0; u < area.width; ++u) {
      const cv::Vec3f& at = source(area.y + v, area.x + u);
      if (at[2] < 0) continue;
      const float x = 0.5f * at[0], y = 0.5f * at[1];
      const int ix = static_cast<int>(x), iy = static_cast<int>(y);
      const float fx = x - static_cast<float>(ix), fy = y - static_cast<float>(iy);
      const auto row = [&](int j) {
        const float left = before(j, ix), right = before(j, ix + 1);
        return left + fx * (right - left);
      };
      const float top = row(iy), bottom = row(iy + 1);
      difference(v, u) =
          static_cast<float>(now(area.y + v, area.x + u)) - (top + fy * (bottom - top));
      known(v, u) = 1;
    }
  for (int v = 0; v < area.height; ++v)
    for (int u = 0; u < area.width; ++u)
      if (known(v, u) > 0)
        deviation(v, u) =
            std::abs(difference(v, u) - sumAround(difference, v, u) / sumAround(known, v, u));
  for (int v = 0; v < area.height; ++v)
    for (int u = 0; u < area.width; ++u) {
      const float count = sumAround(known, v, u);
      if (known(v, u) > 0 && count >= 12.5f) result(v, u) = sumAround(deviation, v, u) / count;
    }
  return result;
}

void expectEqual(const cv::Mat1f& a, const cv::Mat1f& b) {
  ASSERT_EQ(a.size(), b.size());
  for (int y = 0; y < a.rows; ++y)
    for (int x = 0; x < a.cols; ++x) ASSERT_EQ(a(y, x), b(y, x)) << x << ' ' << y;
}

const std::vector<cv::Size> kSizes = {{1, 1},   {3, 2},    {4, 40},   {17, 9},   {30, 30},
                                      {66, 41}, {129, 34}, {258, 20}, {401, 120}};

TEST(FrameComparison, MismatchIsThatOfTheReference) {
  for (cv::Size size : kSizes) {
    SCOPED_TRACE(size);
    const Frames frames(size);
    const SourceOf source_of(disparityMotion(frames.rig, frames.T_prev_cam));
    const cv::Size lattice = frames.current.level(1).size();
    for (cv::Rect area : {cv::Rect(cv::Point(), lattice), cv::Rect(3, 2, 70, 9),
                          cv::Rect(lattice.width / 2, lattice.height / 3, 3, 200)}) {
      area &= cv::Rect(cv::Point(), lattice);
      if (area.empty()) continue;
      const cv::Mat1f expected = mismatch(frames, source_of, area);
      if (area.area() > 5000) {
        EXPECT_GT(cv::countNonZero(expected >= 0), area.area() / 2);
        EXPECT_GT(cv::countNonZero(expected < 0), area.area() / 50);
      }
      forEveryTarget([&] {
        cv::Mat1f found;
        // A buffer that was larger before, with arbitrary content.
        compareFrames(frames.current, frames.lattice_px(), frames.previous, source_of,
                      cv::Rect(cv::Point(), lattice), found);
        compareFrames(frames.current, frames.lattice_px(), frames.previous, source_of, area, found);
        expectEqual(found, expected);
      });
    }
  }
}

// Also points exactly in the plane of the previous camera.
TEST(FrameComparison, PointsBehindThePreviousCameraAreUnknown) {
  Frames frames({64, 48});
  for (const double forward_m : {-0.6 * 64 * 0.5 / 5, -30.0}) {
    frames.disparity_px = 5;
    frames.T_prev_cam = Eigen::Isometry3d::Identity();
    frames.T_prev_cam.translation().z() = forward_m;
    const SourceOf source_of(disparityMotion(frames.rig, frames.T_prev_cam));
    forEveryTarget([&] {
      cv::Mat1f found;
      compareFrames(frames.current, frames.lattice_px(), frames.previous, source_of, {0, 0, 32, 24},
                    found);
      EXPECT_EQ(cv::countNonZero(found == kUnknownMismatch), 32 * 24);
    });
  }
}

}  // namespace
}  // namespace predictive_stereo
