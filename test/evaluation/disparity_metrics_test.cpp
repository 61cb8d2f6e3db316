#include "evaluation/disparity_metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace predictive_stereo {
namespace {

TEST(DisparityScore, CountsByHand) {
  const cv::Mat1f truth_px = (cv::Mat1f(1, 8) << 10, 10, 10, 100, 100, 0, kNoTruth, 10);
  // exact, +1, outlier, 4.9 off but within 5 %, outlier, exact at infinity, no truth, invalid
  const cv::Mat1f disparity_px = (cv::Mat1f(1, 8) << 10, 11, 13.5, 104.9, 94.9, 0, 7, -1);
  const DisparityScore score = scoreDisparity(disparity_px, DisparityRange{}, truth_px);
  EXPECT_EQ(score.truth_pixels, 7);
  EXPECT_EQ(score.valid_pixels, 6);
  EXPECT_EQ(score.outliers, 2);
  EXPECT_NEAR(score.density_percent(), 600.0 / 7, 1e-9);
  EXPECT_NEAR(score.d1_percent(), 200.0 / 6, 1e-9);
  EXPECT_NEAR(score.d1_filled_percent(), 300.0 / 7, 1e-9);
  EXPECT_NEAR(score.rms_px(), std::sqrt((1 + 4.9 * 4.9) / 4), 1e-5);
}

TEST(DisparityScore, MaskLeavesOut) {
  const cv::Mat1f truth_px(2, 2, 10.0f), disparity_px(2, 2, 50.0f);
  cv::Mat1b mask(2, 2, uchar{0});
  mask(1, 1) = 255;
  EXPECT_EQ(scoreDisparity(disparity_px, {}, truth_px, mask).outliers, 1);
  EXPECT_THROW(scoreDisparity(disparity_px, {}, cv::Mat1f(2, 3, 1.0f)), std::invalid_argument);
}

TEST(MeanDisparityScore, WeighsFramesNotPixels) {
  DisparityScore good, bad, empty, blind;
  good.truth_pixels = good.valid_pixels = 1000;
  bad.truth_pixels = bad.valid_pixels = bad.outliers = 10;
  blind.truth_pixels = 5;
  MeanDisparityScore mean;
  for (const auto& score : {good, bad, empty, blind}) mean.add(score);
  EXPECT_EQ(mean.frames, 3);
  EXPECT_NEAR(mean.d1_percent, 50, 1e-9);
  EXPECT_NEAR(mean.d1_filled_percent, 200.0 / 3, 1e-9);
  EXPECT_NEAR(mean.density_percent, 200.0 / 3, 1e-9);
}

TEST(VarianceCalibration, NormalErrorsGiveTheNormalShares) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  VarianceCalibration right, too_small;
  for (int i = 0; i < 200000; ++i) {
    const double sigma_px = 0.2 + (i % 7);
    const double error_px = sigma_px * normal(random);
    right.add(error_px, sigma_px * sigma_px);
    too_small.add(error_px, sigma_px * sigma_px / 4);
  }
  EXPECT_NEAR(right.shareWithin(1), 0.6827, 0.005);
  EXPECT_NEAR(right.shareWithin(2), 0.9545, 0.003);
  EXPECT_NEAR(right.shareWithin(3), 0.9973, 0.001);
  EXPECT_NEAR(too_small.shareWithin(2), 0.6827, 0.005);
  EXPECT_LT(right.negativeLogLikelihood(), too_small.negativeLogLikelihood());
  EXPECT_NEAR(right.meanSigma_px(), 3.2, 1e-3);
  EXPECT_THROW(right.add(0.1, 0.0), std::invalid_argument);
}

TEST(VarianceCalibration, LikelihoodByHand) {
  VarianceCalibration a;
  a.add(2.0, 4.0);
  a.add(0.0, 1.0);
  EXPECT_EQ(a.count(), 2);
  EXPECT_NEAR(a.negativeLogLikelihood(),
              (std::log(std::sqrt(2 * M_PI) * 2) + 0.5 + std::log(std::sqrt(2 * M_PI))) / 2, 1e-12);
  EXPECT_DOUBLE_EQ(a.shareWithin(0.5), 0.5);
}

Sparsification sparsificationOf(const std::vector<double>& errors_px,
                                const std::vector<double>& doubts) {
  Sparsification pixels;
  for (size_t i = 0; i < errors_px.size(); ++i) pixels.add(errors_px[i], doubts[i]);
  return pixels;
}

TEST(Sparsification, RightOrderIsTheOracles) {
  const Sparsification pixels = sparsificationOf({3, -1, 0, 8}, {0.3, 0.2, 0.1, 9});
  EXPECT_DOUBLE_EQ(pixels.meanError_px(), 3);
  EXPECT_NEAR(pixels.ause_px(), 0, 1e-12);
}

// Means of the first ones: oracle 0, 2; the other way round 4, 2.
TEST(Sparsification, IsTheAreaBetweenTheCurves) {
  EXPECT_NEAR(sparsificationOf({4, 0}, {1, 2}).ause_px(), 2, 1e-12);
  EXPECT_NEAR(sparsificationOf({4, 0}, {1, 1}).ause_px(), 1, 1e-12);
  EXPECT_NEAR(sparsificationOf({4, 0}, {1, 2}).auseOfNothing_px(), 1, 1e-12);
}

TEST(Sparsification, HasNoPixelsAtFirst) {
  EXPECT_TRUE(Sparsification().empty());
  EXPECT_EQ(Sparsification().ause_px(), 0);
  EXPECT_EQ(Sparsification().auseOfNothing_px(), 0);
}

}  // namespace
}  // namespace predictive_stereo
