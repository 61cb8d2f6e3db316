/// The SIMD kernels of the block search against the plain reference.
#include "odometry/block_kernel.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "matching/simd_dispatch.h"
#include "predictive_stereo/simd_target.h"

namespace predictive_stereo {
namespace {

struct Sums {
  std::vector<int32_t> grey, grey_grey, products;
};

Sums run(BlockKernel kernel, const cv::Mat1b& image, int positions) {
  float block[kBlockArea];
  for (int i = 0; i < kBlockArea; ++i) block[i] = image(i / kBlockSize, i % kBlockSize);
  const auto n = static_cast<size_t>(positions);
  Sums sums{std::vector<int32_t>(n), std::vector<int32_t>(n), std::vector<int32_t>(n)};
  kernel(block, image.ptr(0), image.step, positions,
         {sums.grey.data(), sums.grey_grey.data(), sums.products.data()});
  return sums;
}

TEST(BlockKernel, EveryTargetGivesTheSame) {
  for (const int positions : {1, 3, 4, 7, 8, 9, 16, 65}) {
    for (const bool white : {false, true}) {
      // Of its own size, so that address sanitizers see what is read.
      cv::Mat1b image(kBlockSize, positions + kBlockSize - 1, uchar{255});
      if (!white) cv::RNG(5).fill(image, cv::RNG::UNIFORM, 0, 256);
      const Sums expected = run(referenceBlockKernel(), image, positions);
      if (white) {
        EXPECT_EQ(expected.products[0], 255 * 255 * kBlockArea);
      }
      for (const std::string& target : availableSimdTargets()) {
        const Sums sums = run(blockKernel(simdTargetBit(target)), image, positions);
        EXPECT_EQ(sums.grey, expected.grey) << target;
        EXPECT_EQ(sums.grey_grey, expected.grey_grey) << target;
        EXPECT_EQ(sums.products, expected.products) << target;
      }
    }
  }
}

}  // namespace
}  // namespace predictive_stereo
