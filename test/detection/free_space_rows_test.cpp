/// Rows of sights are identical to plain code, on every SIMD target.
#include "detection/free_space_rows.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <random>
#include <vector>

#include "every_target.h"

namespace predictive_stereo {
namespace {

constexpr int kFrames = 3, kStep_px = 2, kCell_px = 4, kCentre_px = 2, kRow_px = 22;
constexpr float kLeast_px = 3;

enum class Sight { kNone, kThrough, kSame };

class FreeSpaceRows : public testing::TestWithParam<int> {
 protected:
  FreeSpaceRows() : random_(static_cast<unsigned>(GetParam())) {
    const auto n = static_cast<size_t>(GetParam());
    for (size_t i = 0; i < n; ++i) {
      disparity.push_back(value(0, 20));
      variance.push_back(value(0, 0.5));
      width.push_back(value(0, 60));
    }
    for (int k = 0; k < kFrames; ++k) {
      nearest[k] = cv::Mat1f(20, 2 * GetParam() + 8);
      farthest[k] = nearest[k].clone();
      for (int v = 0; v < nearest[k].rows; ++v)
        for (int u = 0; u < nearest[k].cols; ++u) {
          farthest[k](v, u) = value(0, 1) < 0.1f ? 0 : value(2, 18);
          nearest[k](v, u) = farthest[k](v, u) > 0 ? farthest[k](v, u) + value(0, 3) : 0;
        }
      // Moves by columns, by a row and in depth.
      H[k] = {1, 0, 0, 0, 0, 1, 0, 0, 0.1f, 0, 1, 0.001f, value(-9, 9), 3, 0.2f, 1};
      past.push_back({H[k].data(),
                      nearest[k][0],
                      farthest[k][0],
                      int(nearest[k].step1()),
                      nearest[k].cols,
                      nearest[k].rows,
                      {0.01f, {0.001f, 0.002f}, {0.0001f, 0.0002f, 0.0003f}}});
    }
  }
  float value(double low, double high) {
    return static_cast<float>(std::uniform_real_distribution<double>(low, high)(random_));
  }
  SightRow row() const {
    return {disparity.data(), variance.data(), width.data(), GetParam(), kCentre_px, kCell_px,
            kRow_px,          kStep_px,        40,           300,        60};
  }

  Sight sightOf(int u, int k) const {
    const std::array<float, 16>& h = H[static_cast<size_t>(k)];
    const auto i = static_cast<size_t>(u);
    const float x = static_cast<float>(kCentre_px + kCell_px * u), y = kRow_px, d = disparity[i];
    const float w = h[3] * x + h[7] * y + h[11] * d + h[15];
    const float per_w = 1 / w;
    const float column = (h[0] * x + h[4] * y + h[8] * d + h[12]) * per_w * 0.5f + 0.5f,
                line = (h[1] * x + h[5] * y + h[9] * d + h[13]) * per_w * 0.5f + 0.5f,
                expected = (h[2] * x + h[6] * y + h[10] * d + h[14]) * per_w;
    const cv::Mat1f &near = nearest[k], &far = farthest[k];
    if (!(expected > 0 && column >= 0 && line >= 0 && column < static_cast<float>(near.cols) &&
          line < static_cast<float>(near.rows)))
      return Sight::kNone;
    const cv::Point p(static_cast<int>(column), static_cast<int>(line));
    if (!(near(p) > 0)) return Sight::kNone;
    if (far(p) <= expected && expected <= near(p)) return Sight::kSame;
    const float by_depth = expected * expected * (1 / 60.0f);
    const float of_depth =
        past[static_cast<size_t>(k)].noise.variance((x - 40) * (1 / 300.0f), 60 / d);
    const float scale2 = kScaleSigma * kScaleSigma;
    const float threshold2 = 4 * (variance[i] + kMapSigma_px * kMapSigma_px +
                                  by_depth * by_depth * of_depth + scale2 * expected * expected);
    const float behind = expected - near(p), before = far(p) - expected;
    if (behind > 0 && behind * behind > threshold2)
      return width[i] * expected < kThinnest_px * d ? Sight::kNone : Sight::kThrough;
    return before < 0 || before * before < threshold2 ? Sight::kSame : Sight::kNone;
  }

  std::vector<float> disparity, variance, width;
  std::array<cv::Mat1f, kFrames> nearest, farthest;
  std::array<std::array<float, 16>, kFrames> H;
  std::vector<PastSight> past;

 private:
  std::mt19937 random_;
};

TEST_P(FreeSpaceRows, CountSights) {
  std::vector<uint8_t> through_by(disparity.size()), fixed(disparity.size());
  int moved = 0;
  forEveryTarget([&] {
    sightsRow(row(), past.data(), kFrames, kLeast_px, through_by.data(), fixed.data());
    for (int u = 0; u < GetParam(); ++u) {
      SCOPED_TRACE(testing::Message() << u);
      int through = 0, same = 0, came_back = 0, first = 0;
      for (int k = 0; k < kFrames && disparity[size_t(u)] >= kLeast_px; ++k) {
        const Sight sight = sightOf(u, k);
        if (sight == Sight::kThrough && ++through == 1) first = k + 1;
        if (sight != Sight::kSame) continue;
        ++same;
        came_back += through > 0;
      }
      EXPECT_EQ(fixed[size_t(u)], same > 0 ? 255 : 0);
      EXPECT_EQ(through_by[size_t(u)], through >= 2 && through > came_back ? first : 0);
      moved += through_by[size_t(u)] != 0;
    }
  });
  if (GetParam() >= 64) {
    EXPECT_GT(moved, 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Widths, FreeSpaceRows, testing::Values(1, 3, 16, 63, 64, 65, 200));

}  // namespace
}  // namespace predictive_stereo
