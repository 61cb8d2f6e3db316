#include "odometry/half_image.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <opencv2/imgproc.hpp>

namespace predictive_stereo {
namespace {

TEST(HalfImage, IsThatOfOpenCvOnEveryTarget) {
  cv::RNG rng(3);
  for (auto targets = hwy::SupportedTargets(); targets; targets &= targets - 1) {
    hwy::SetSupportedTargetsForTest(targets & ~(targets - 1));
    for (const cv::Size size :
         {cv::Size(1, 1), cv::Size(2, 3), cv::Size(5, 2), cv::Size(16, 9), cv::Size(31, 8),
          cv::Size(32, 32), cv::Size(33, 7), cv::Size(67, 41), cv::Size(621, 30)})
      for (const int darkest : {0, 255}) {
        // Of its own memory, so that address sanitizers see what is read.
        cv::Mat1b image(size), expected, half;
        rng.fill(image, cv::RNG::UNIFORM, darkest, 256);
        cv::pyrDown(image, expected);
        halve(image, half);
        ASSERT_EQ(half.size(), expected.size());
        EXPECT_EQ(cv::norm(half, expected, cv::NORM_INF), 0) << size << " from " << darkest;
      }
  }
  hwy::SetSupportedTargetsForTest(0);
}

TEST(HalfImage, ReadsViewsAndKeepsMemory) {
  cv::Mat1b large(40, 60), expected, half(18, 25);
  cv::RNG(4).fill(large, cv::RNG::UNIFORM, 0, 256);
  const cv::Mat1b view = large(cv::Rect(3, 2, 50, 36));
  const uchar* memory = half.data;
  halve(view, half);
  EXPECT_EQ(half.data, memory);
  cv::pyrDown(view.clone(), expected);
  EXPECT_EQ(cv::norm(half, expected, cv::NORM_INF), 0);
}

}  // namespace
}  // namespace predictive_stereo
