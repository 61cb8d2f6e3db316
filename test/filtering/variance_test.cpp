#include "predictive_stereo/variance.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>

namespace predictive_stereo {
namespace {

const DisparityRange kRange{0, 128};

TEST(Variance, MeasurementVarianceGrowsWithAmbiguityAndDisparity) {
  VarianceParams params;
  cv::Mat1f disparity_px = (cv::Mat1f(1, 4) << 0.0f, 64.0f, 0.0f, kRange.invalid());
  cv::Mat1b ambiguity = (cv::Mat1b(1, 4) << 0, 0, 255, 0);
  cv::Mat1f variance_px2;
  measurementVariance(disparity_px, ambiguity, kRange, params, variance_px2);
  EXPECT_NEAR(variance_px2(0), params.sigma_floor_px * params.sigma_floor_px, 1e-6);
  const double far = params.sigma_floor_px + 64 * params.sigma_per_disparity;
  EXPECT_NEAR(variance_px2(1), far * far, 1e-5);
  const double tie = params.sigma_floor_px + params.sigma_ambiguous_px;
  EXPECT_NEAR(variance_px2(2), tie * tie, 1e-5);
  EXPECT_EQ(variance_px2(3), 0.0f);
}

TEST(Variance, MeasurementVarianceIsTheFormulaOnEveryTarget) {
  const VarianceParams params;
  cv::RNG rng(3);
  for (auto targets = hwy::SupportedTargets(); targets; targets &= targets - 1) {
    hwy::SetSupportedTargetsForTest(targets & ~(targets - 1));
    for (int min_disparity : {0, -16, 16})
      for (cv::Size size : {cv::Size(1, 1), cv::Size(7, 3), cv::Size(8, 1), cv::Size(1242, 5)}) {
        const DisparityRange range{min_disparity, 128};
        cv::Mat1f disparity_px(size), variance_px2;
        cv::Mat1b ambiguity(size);
        rng.fill(ambiguity, cv::RNG::UNIFORM, 0, 256);
        rng.fill(disparity_px, cv::RNG::UNIFORM, min_disparity - 3.0f, min_disparity + 127.0f);
        disparity_px.setTo(range.invalid(), disparity_px < min_disparity);
        measurementVariance(disparity_px, ambiguity, range, params, variance_px2);
        for (int y = 0; y < size.height; ++y)
          for (int x = 0; x < size.width; ++x) {
            const float d = disparity_px(y, x);
            const double t = std::max(0.0, (ambiguity(y, x) / 255.0 - params.ambiguity_onset) /
                                               (1 - params.ambiguity_onset));
            const auto by_ambiguity =
                static_cast<float>(params.sigma_floor_px + params.sigma_ambiguous_px * t * t);
            const float sigma =
                by_ambiguity + static_cast<float>(params.sigma_per_disparity) * std::max(d, 0.0f);
            ASSERT_EQ(variance_px2(y, x), range.isValid(d) ? sigma * sigma : 0) << size << x;
          }
      }
  }
  hwy::SetSupportedTargetsForTest(0);
}

TEST(Variance, PublishedVarianceTellsHowTheDisparityCameAbout) {
  // Measured as predicted, measured against the prediction, measured without one, kept, filled,
  // unknown; measured and kept near a discontinuity.
  const float no = kRange.invalid();
  const cv::Mat1f published = (cv::Mat1f(1, 8) << 20, 22, 20, 20, 20, no, 20, 20);
  const cv::Mat1f measured = (cv::Mat1f(1, 8) << 20, 22, 20, no, no, no, 20, no);
  const cv::Mat1f measured_variance = (cv::Mat1f(1, 8) << 0.1f, 0.1f, 0.1f, 0, 0, 0, 0.1f, 0);
  Prediction prediction;
  Predictor(kRange, PredictionParams()).predictNothing(published.size(), prediction);
  prediction.disparity_px = (cv::Mat1f(1, 8) << 20, 20, no, 20, no, no, 20, 20);
  prediction.near_edge(6) = prediction.near_edge(7) = 255;
  DisparityState state;
  state.disparity_px = (cv::Mat1f(1, 8) << 20, 22, 20, 20, no, no, 20, 20);
  state.variance_px2 = cv::Mat1f(1, 8, 0.3f);
  state.missed_frames = cv::Mat1b(1, 8, uchar{0});
  VarianceParams params;
  params.innovation_weight = 0.5;
  params.sigma_unpredicted_px = 1.0;
  params.sigma_kept_px = 1.5;
  params.sigma_filled_px = 2.0;
  params.sigma_edge_px = 0.5;
  params.sigma_kept_edge_px = 3.0;
  cv::Mat1f variance_px2;
  publishedVariance(published, state, prediction, measured, measured_variance, kRange, params,
                    variance_px2);
  const float expected[] = {0.1f, 0.1f + 0.5f * 4, 0.1f + 1, 0.3f + 2.25f, 4, 0, 0.35f, 9};
  for (int i = 0; i < 8; ++i) EXPECT_NEAR(variance_px2(i), expected[i], 1e-5) << i;
}

TEST(Variance, LargeInnovationsAreCapped) {
  Prediction prediction;
  Predictor(kRange, PredictionParams()).predictNothing({1, 1}, prediction);
  prediction.disparity_px = 20.0f;
  const cv::Mat1f measured(1, 1, 90.0f), measured_variance(1, 1, 0.1f);
  DisparityState state;
  state.disparity_px = measured;
  state.variance_px2 = cv::Mat1f(1, 1, 0.4f);
  VarianceParams params;
  params.innovation_weight = 0.25;
  params.max_innovation_px = 4;
  cv::Mat1f variance_px2;
  publishedVariance(measured, state, prediction, measured, measured_variance, kRange, params,
                    variance_px2);
  EXPECT_NEAR(variance_px2(0), 0.1 + 0.25 * 16, 1e-5);
}

}  // namespace
}  // namespace predictive_stereo
