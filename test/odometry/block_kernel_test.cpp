/// The SIMD kernels of the block search are identical to the plain reference.
#include "odometry/block_kernel.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <vector>

#include "predictive_stereo/simd_target.h"
#include "simd/simd_dispatch.h"

namespace predictive_stereo {
namespace {

std::vector<float> run(BlockKernel kernel, const cv::Mat1b& block, const cv::Mat1b& row) {
  std::vector<float> correlation(static_cast<size_t>(row.cols - kBlockSize + 1));
  kernel({block.ptr(), block.step}, {row.ptr(), row.step}, static_cast<int>(correlation.size()),
         correlation.data());
  return correlation;
}

TEST(BlockKernel, ReferenceIsTheCorrelation) {
  cv::Mat1b block(kBlockSize, kBlockSize), row(kBlockSize, 40);
  cv::RNG random(3);
  random.fill(block, cv::RNG::UNIFORM, 0, 256);
  random.fill(row, cv::RNG::UNIFORM, 0, 256);
  cv::Mat1b brighter = row(cv::Rect(21, 0, kBlockSize, kBlockSize));
  cv::Mat(block / 2 + 60).copyTo(brighter);
  const std::vector<float> correlation = run(referenceBlockKernel(), block, row);
  EXPECT_GT(correlation[21], 0.999f);
  for (int i : {0, 8, 20}) {
    cv::Mat expected;
    cv::matchTemplate(row.colRange(i, i + kBlockSize), block, expected, cv::TM_CCOEFF_NORMED);
    EXPECT_NEAR(correlation[static_cast<size_t>(i)], expected.at<float>(0), 1e-4) << i;
  }
}

TEST(BlockKernel, EveryTargetGivesTheSame) {
  for (const int positions : {1, 3, 4, 7, 8, 9, 16, 65, 72, 73, 150}) {
    for (const int darkest : {0, 250, 255}) {
      // Separate images of this size, so that address sanitizers detect reads outside.
      cv::Mat1b block(kBlockSize, kBlockSize), row(kBlockSize, positions + kBlockSize - 1);
      cv::RNG random(5);
      random.fill(block, cv::RNG::UNIFORM, darkest, 256);
      random.fill(row, cv::RNG::UNIFORM, darkest, 256);
      const std::vector<float> expected = run(referenceBlockKernel(), block, row);
      for (const std::string& target : availableSimdTargets())
        EXPECT_EQ(run(blockKernel(simdTargetBit(target)), block, row), expected) << target;
    }
  }
}

}  // namespace
}  // namespace predictive_stereo
