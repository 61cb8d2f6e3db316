#include "predictive_stereo/residual.h"

#include <gtest/gtest.h>

namespace predictive_stereo {
namespace {

TEST(NormalizedResidual, DividesByBothStandardDeviations) {
  const DisparityRange range{4, 64};
  const cv::Mat1f measured = (cv::Mat1f(1, 5) << 10, 10, 3, 10, 60);
  const cv::Mat1f predicted = (cv::Mat1f(1, 5) << 8, 12, 8, 3, 5);
  const cv::Mat1f measured_variance = (cv::Mat1f(1, 5) << 0.36f, 9, 0, 1, 0.5f);
  const cv::Mat1f predicted_variance = (cv::Mat1f(1, 5) << 0.64f, 16, 1, 0, 0.5f);
  cv::Mat1f residual;
  normalizedResidual(measured, measured_variance, predicted, predicted_variance, range, residual);
  EXPECT_FLOAT_EQ(residual(0), 2.0f);
  EXPECT_FLOAT_EQ(residual(1), -0.4f);
  EXPECT_EQ(residual(2), 0.0f);  // not measured
  EXPECT_EQ(residual(3), 0.0f);  // not predicted
  EXPECT_EQ(residual(4), kLargestResidual);
}

TEST(AbsoluteDifference, IsCutAndZeroWhereUnknown) {
  const DisparityRange range{0, 64};
  const cv::Mat1f measured = (cv::Mat1f(1, 4) << 10, 2, -1, 10);
  const cv::Mat1f predicted = (cv::Mat1f(1, 4) << 8, 20, 8, -1);
  cv::Mat1f difference;
  absoluteDifference(measured, predicted, range, 5, difference);
  EXPECT_EQ(difference(0), 2.0f);
  EXPECT_EQ(difference(1), 5.0f);
  EXPECT_EQ(difference(2), 0.0f);
  EXPECT_EQ(difference(3), 0.0f);
}

}  // namespace
}  // namespace predictive_stereo
