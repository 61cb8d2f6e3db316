/// Patches are identical to a plain reference, on every SIMD target.
#include "detection/patch_rows.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

#include "every_target.h"

namespace predictive_stereo {
namespace {

constexpr int kSide = GreyPatch::kSide;

cv::Mat1b noise(cv::Size size) {
  cv::Mat1b image(size);
  cv::RNG(size.area()).fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

std::array<double, GreyPatch::kArea> reference(const cv::Mat1b& image, int x, int y, double fx,
                                               double fy) {
  std::array<double, GreyPatch::kArea> patch;
  double sum = 0;
  for (int v = 0; v < kSide; ++v)
    for (int u = 0; u < kSide; ++u) {
      const double value =
          (1 - fy) * ((1 - fx) * image(y + v, x + u) + fx * image(y + v, x + u + 1)) +
          fy * ((1 - fx) * image(y + v + 1, x + u) + fx * image(y + v + 1, x + u + 1));
      sum += patch[static_cast<size_t>(kSide * v + u)] = value;
    }
  for (double& value : patch) value -= sum / GreyPatch::kArea;
  return patch;
}

// The result, which must be the same on every target.
template <class Body>
void expectSameOnEveryTarget(const Body& body) {
  std::vector<decltype(body())> results;
  forEveryTarget([&] { results.push_back(body()); });
  for (const auto& result : results) EXPECT_EQ(result, results.front());
}

TEST(PatchRows, AreThoseOfTheReference) {
  const cv::Mat1b now = noise({40, 30}), then = noise({50, 20});
  const auto stride = static_cast<std::ptrdiff_t>(then.step);
  cv::RNG rng(5);
  for (int i = 0; i < 50; ++i) {
    const int x = rng.uniform(0, then.cols - kPatchColumns + 1),
              y = rng.uniform(0, then.rows - kPatchRows + 1);
    const float fx = i % 3 == 0 ? 0.0f : rng.uniform(0.0f, 1.0f),
                fy = i % 5 == 0 ? 0.0f : rng.uniform(0.0f, 1.0f);
    const auto expected_now = reference(now, 7, 9, 0, 0), expected = reference(then, x, y, fx, fy);
    double texture = 0, difference = 0;
    for (size_t k = 0; k < expected.size(); ++k) {
      texture += std::abs(expected_now[k]) / GreyPatch::kArea;
      difference += std::abs(expected_now[k] - expected[k]) / GreyPatch::kArea;
    }
    expectSameOnEveryTarget([&] {
      GreyPatch patch;
      patchBetween(&now(9, 7), static_cast<std::ptrdiff_t>(now.step), 0, 0, patch);
      for (int v = 0; v < kSide; ++v)
        for (int u = 0; u < kSide; ++u)
          EXPECT_NEAR(patch.grey[GreyPatch::kStride * v + u],
                      expected_now[static_cast<size_t>(kSide * v + u)], 1e-4);
      const float found = patchDifference(patch, &then(y, x), stride, fx, fy);
      EXPECT_NEAR(patchTexture(patch), texture, 1e-4);
      EXPECT_NEAR(found, difference, 1e-4);
      return found;
    });
  }
}

}  // namespace
}  // namespace predictive_stereo
