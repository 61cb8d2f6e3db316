#include "predictive_stereo/variance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core/utility.hpp>
#include <stdexcept>
#include <vector>

#include "every_target.h"

namespace predictive_stereo {
namespace {

const DisparityRange kRange{0, 128};

TEST(Variance, MeasurementVarianceGrowsWithAmbiguity) {
  VarianceParams params;
  cv::Mat1f disparity_px = (cv::Mat1f(1, 4) << 0.0f, 64.0f, 0.0f, kRange.invalid());
  cv::Mat1b ambiguity = (cv::Mat1b(1, 4) << 0, 0, 255, 0);
  cv::Mat1f variance_px2;
  measurementVariance(disparity_px, ambiguity, kRange, params, variance_px2);
  EXPECT_NEAR(variance_px2(0), params.sigma_floor_px * params.sigma_floor_px, 1e-6);
  EXPECT_EQ(variance_px2(1), variance_px2(0));
  const double tie = params.sigma_floor_px + params.sigma_ambiguous_px;
  EXPECT_NEAR(variance_px2(2), tie * tie, 1e-5);
  EXPECT_EQ(variance_px2(3), 0.0f);
}

TEST(Variance, MeasurementVarianceIsTheFormulaOnEveryTarget) {
  const VarianceParams params;
  cv::RNG rng(3);
  forEveryTarget([&] {
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
            const double sigma = params.sigma_floor_px + params.sigma_ambiguous_px * t * t;
            ASSERT_EQ(variance_px2(y, x), range.isValid(d) ? static_cast<float>(sigma * sigma) : 0)
                << size << x;
          }
      }
  });
}

/// Eight pairs of opposite pixels, in the order of the kernel: sums of floats depend on it.
float disagreementNaively(const cv::Mat1f& map, const DisparityRange& range, int x, int y) {
  const auto rise = [&](int dx, int dy) {
    const float there = map(y + dy, x + dx);
    return range.isValid(there) ? there - map(y, x) : std::nanf("");
  };
  float sum_px = 0;
  for (int reach : {4, 9}) {
    const int columns = std::min({reach, x, map.cols - 1 - x});
    const int rows = std::min({reach, y, map.rows - 1 - y});
    for (const cv::Point& step :
         {cv::Point(-1, -1), cv::Point(0, -1), cv::Point(1, -1), cv::Point(-1, 0)}) {
      const float bend_px =
          std::abs(rise(columns * step.x, rows * step.y) + rise(-columns * step.x, -rows * step.y));
      sum_px += bend_px < 4 ? bend_px : 4.0f;
    }
  }
  return sum_px * 0.25f;
}

/// The standard deviation that is published if nothing but disagreement adds to it.
cv::Mat1f disagreementOf(const cv::Mat1f& map, const DisparityRange& range) {
  VarianceParams params;
  params.sigma_disagreement_px = 1;
  params.ambiguity_weight = params.unpredicted_weight = 0;
  params.residual_weight = params.slope_weight = 0;
  const cv::Mat1f nothing = cv::Mat1f::zeros(map.size());
  cv::Mat1f published_px, variance_px2, sigma_px;
  publish(map, {map, map, map, nothing, cv::Mat1b(map.size(), uchar{0}), nothing}, range, params,
          published_px, variance_px2);
  cv::sqrt(variance_px2, sigma_px);
  return sigma_px;
}

TEST(Variance, DisagreementIsThatOfTheDefinitionOnEveryTarget) {
  cv::RNG rng(5);
  forEveryTarget([&] {
    for (int min_disparity : {0, -16, 16})
      for (cv::Size size :
           {cv::Size(1, 1), cv::Size(3, 9), cv::Size(8, 4), cv::Size(9, 12), cv::Size(130, 37)}) {
        const DisparityRange range{min_disparity, 128};
        cv::Mat1f map(size);
        rng.fill(map, cv::RNG::UNIFORM, min_disparity - 1.0f, min_disparity + 8.0f);
        map.setTo(range.invalid(), map < min_disparity);
        const cv::Mat1f disagreement = disagreementOf(map, range);
        for (int y = 0; y < size.height; ++y)
          for (int x = 0; x < size.width; ++x) {
            if (!range.isValid(map(y, x))) continue;
            ASSERT_EQ(disagreement(y, x), disagreementNaively(map, range, x, y))
                << size << x << "," << y;
          }
      }
  });
}

TEST(Variance, SteepSurfacesAgreeAndSpecksDoNot) {
  cv::Mat1f map(60, 60);
  for (int y = 0; y < map.rows; ++y)
    for (int x = 0; x < map.cols; ++x) map(y, x) = static_cast<float>(y + x);
  map(cv::Rect(35, 35, 5, 5)) = 5.0f;
  const cv::Mat1f disagreement = disagreementOf(map, kRange);
  EXPECT_EQ(disagreement(12, 12), 0);
  for (int i = 0; i < 9; ++i)  // beside the borders, too
    for (const float beside : {disagreement(i, 12), disagreement(12, i), disagreement(i, i),
                               disagreement(59 - i, 12), disagreement(12, 59 - i)})
      EXPECT_EQ(beside, 0) << i;
  EXPECT_EQ(disagreement(37, 37), 8);
  EXPECT_EQ(disagreement(37, 33), 1);  // beside the speck: the pair with a pixel in it
}

TEST(Variance, RectificationCountsByItsRowOffset) {
  EXPECT_EQ(rectificationShare(0), 1);  // not measured
  EXPECT_LT(rectificationShare(0.03), 0.05);
  EXPECT_DOUBLE_EQ(rectificationShare(kHalfShareRowOffsetPx), 0.5);
  EXPECT_GT(rectificationShare(1), 0.95);
}

/// One pixel of each kind, far from others of its row.
class PublishedVarianceTest : public testing::Test {
 protected:
  static constexpr int kApart = 10;
  void SetUp() override {
    params_.sigma_floor_px = 1.5;
    params_.sigma_unpredicted_px = 1.0;
    params_.sigma_filled_px = 2.0;
    params_.sigma_disagreement_px = 0.1;
    params_.ambiguity_weight = 2;
    params_.unpredicted_weight = 0.25;
    params_.residual_weight = 3;
    params_.sigma_per_row_offset = 0.02;
  }
  void add(float published, float measured, float predicted, bool filtered) {
    published_.push_back(published);
    measured_.push_back(measured);
    predicted_.push_back(predicted);
    filtered_.push_back(filtered ? published : kRange.invalid());
  }
  /// Variances of the pixels that were added.
  cv::Mat1f run(double row_offset_px, float residual_share = 0) const {
    const int width = kApart * static_cast<int>(published_.size());
    const cv::Mat1f nothing(1, width, kRange.invalid());
    cv::Mat1f published = nothing.clone(), measured = nothing.clone();
    cv::Mat1f predicted = nothing.clone(), unfilled = nothing.clone();
    for (size_t i = 0; i < published_.size(); ++i) {
      const int x = static_cast<int>(i) * kApart;
      published(x) = published_[i];
      measured(x) = measured_[i];
      predicted(x) = predicted_[i];
      unfilled(x) = filtered_[i];
    }
    cv::Mat1f certain_px, variance_px2, picked(1, static_cast<int>(published_.size()));
    publish(published,
            {unfilled, predicted, measured, cv::Mat1f(1, width, 0.1f),
             cv::Mat1b(1, width, uchar{51}), cv::Mat1f(1, width, residual_share), row_offset_px},
            kRange, params_, certain_px, variance_px2);
    for (int i = 0; i < picked.cols; ++i) picked(i) = variance_px2(i * kApart);
    return picked;
  }

  VarianceParams params_;
  std::vector<float> published_, measured_, predicted_, filtered_;
};

TEST_F(PublishedVarianceTest, TellsHowTheDisparityCameAbout) {
  const float no = kRange.invalid();
  add(20, 20, 20, true);   // measured as predicted; at the border, where no pair disagrees
  add(20, 20, 20, true);   // the same inside the image
  add(20, 20, no, true);   // measured without one
  add(20, no, 20, true);   // kept
  add(20, no, no, false);  // filled
  add(no, no, no, false);  // unknown
  const cv::Mat1f variance_px2 = run(0);
  // Eight pairs, or two in a column of one row; ambiguity 0.2 of matches, 1 of others.
  const auto surroundings = [](float pairs, float doubt) {
    return 0.01f * pairs * pairs * doubt * doubt;
  };
  const float expected[] = {0.1f,
                            0.1f + surroundings(6, 1.08f),
                            1.1f + surroundings(6, 1.33f),
                            2.25f + surroundings(6, 3),
                            4 + surroundings(6, 3),
                            0};
  for (int i = 0; i < variance_px2.cols; ++i) EXPECT_NEAR(variance_px2(i), expected[i], 1e-5) << i;
}

TEST_F(PublishedVarianceTest, GrowsWithRowOffsetTimesDisparity) {
  add(10, 10, 10, true);
  add(50, 50, 50, true);
  const cv::Mat1f more_px2 = run(0.7) - run(0);
  EXPECT_NEAR(more_px2(0), 0.02 * 0.02 * 0.49 * 100, 1e-5);
  EXPECT_NEAR(more_px2(1), 0.02 * 0.02 * 0.49 * 2500, 1e-5);
}

TEST_F(PublishedVarianceTest, GrowsWithTheResidualWhereSurroundingsDisagree) {
  for (int i = 0; i < 2; ++i) add(20, 20, 20, true);  // no pair disagrees around the first one
  ASSERT_GT(run(0)(1), 0.2);
  EXPECT_NEAR(run(0, 0.5f)(1) - 0.1, 2.5 * 2.5 * (run(0)(1) - 0.1), 1e-5);
}

TEST(Variance, FallsWhereDisparitiesGrowDownwards) {
  const auto atCentre = [](float px_per_row) {
    cv::Mat1f map(41, 41), published_px, variance_px2;
    for (int y = 0; y < map.rows; ++y) map.row(y) = 60 + px_per_row * static_cast<float>(y - 20);
    publish(map,
            {map, map, map, cv::Mat1f(map.size(), 0.1f), cv::Mat1b(map.size(), uchar{0}),
             cv::Mat1f(map.size(), 0.0f)},
            kRange, VarianceParams(), published_px, variance_px2);
    return variance_px2(20, 20);
  };
  const double steepness = 1 + 0.5 * VarianceParams().slope_weight;
  EXPECT_NEAR(atCentre(0), 0.1, 1e-6);
  EXPECT_NEAR(atCentre(-0.5), 0.1, 1e-6);
  EXPECT_NEAR(atCentre(0.5), 0.1 / (steepness * steepness), 1e-6);
}

/// Maps of random disparities, a fifth of them unknown.
struct RandomFrame {
  RandomFrame(cv::Size size, const DisparityRange& range, cv::RNG& rng) {
    for (cv::Mat1f* map :
         {&disparity_px, &evidence.unfilled_px, &evidence.predicted_px, &evidence.measured_px}) {
      map->create(size);
      const auto smallest = static_cast<float>(range.min_disparity);
      rng.fill(*map, cv::RNG::UNIFORM, smallest - 2.0f, smallest + 8.0f);
      map->setTo(range.invalid(), *map < smallest);
    }
    evidence.ambiguity.create(size);
    rng.fill(evidence.ambiguity, cv::RNG::UNIFORM, 0, 256);
    evidence.measured_variance_px2.create(size);
    rng.fill(evidence.measured_variance_px2, cv::RNG::UNIFORM, 0.05f, 2.0f);
    evidence.residual_share.create(size);
    rng.fill(evidence.residual_share, cv::RNG::UNIFORM, 0.0f, 1.0f);
    evidence.row_offset_px = 0.7;
  }
  cv::Mat1f disparity_px;
  DisparityEvidence evidence;
};

float varianceNaively(const RandomFrame& frame, const DisparityRange& range,
                      const VarianceParams& params, int x, int y) {
  const auto squared = [](double value) { return static_cast<float>(value * value); };
  const DisparityEvidence& evidence = frame.evidence;
  const cv::Mat1f& map = frame.disparity_px;
  const float d = map(y, x);
  const bool is_measured = range.isValid(evidence.measured_px(y, x));
  const bool alone = is_measured && !range.isValid(evidence.predicted_px(y, x));
  const float ambiguity = is_measured ? evidence.ambiguity(y, x) * (1.0f / 255) : 1.0f;
  const float doubt = 1 + static_cast<float>(params.ambiguity_weight) * ambiguity * ambiguity +
                      (alone ? static_cast<float>(params.unpredicted_weight) : 0);
  const float unlike =
      1 + static_cast<float>(params.residual_weight) * evidence.residual_share(y / 4, x / 4);
  const float around = static_cast<float>(params.sigma_disagreement_px) *
                       disagreementNaively(map, range, x, y) * (doubt * unlike);
  float variance_px2 =
      is_measured ? evidence.measured_variance_px2(y, x) : squared(params.sigma_floor_px);
  if (alone)
    variance_px2 +=
        squared(params.sigma_unpredicted_px * rectificationShare(evidence.row_offset_px));
  if (!range.isValid(evidence.unfilled_px(y, x))) variance_px2 = squared(params.sigma_filled_px);
  variance_px2 += around * around;
  const float per_disparity = squared(params.sigma_per_row_offset * evidence.row_offset_px);
  variance_px2 += per_disparity * d * d;
  const int reach = std::min({4, y, map.rows - 1 - y});
  const float above = map(y - reach, x), below = map(y + reach, x);
  const bool rises = range.isValid(above) && below > above;
  const float per_rise = static_cast<float>(params.slope_weight) * (0.5f / float(reach));
  const float steepness = 1 + (rises ? per_rise * (below - above) : 0);
  return variance_px2 / (steepness * steepness);
}

TEST(Variance, WhatIsPublishedIsTheDefinitionOnEveryTargetAndNumberOfThreads) {
  const int threads_before = cv::getNumThreads();
  cv::RNG rng(7);
  forEveryTarget([&] {
    for (int min_disparity : {0, -16, 16})
      for (double max_sigma_px : {0.0, 4.0})
        for (int threads : {1, 3})
          for (cv::Size size : {cv::Size(1, 1), cv::Size(3, 9), cv::Size(8, 4), cv::Size(9, 12),
                                cv::Size(16, 3), cv::Size(130, 37)}) {
            cv::setNumThreads(threads);
            const DisparityRange range{min_disparity, 128};
            const RandomFrame frame(size, range, rng);
            VarianceParams params;
            params.max_sigma_px = max_sigma_px;
            cv::Mat1f published_px, variance_px2;
            publish(frame.disparity_px, frame.evidence, range, params, published_px, variance_px2);
            for (int y = 0; y < size.height; ++y)
              for (int x = 0; x < size.width; ++x) {
                const float d = frame.disparity_px(y, x);
                const float v = varianceNaively(frame, range, params, x, y);
                const bool certain = range.isValid(d) && (max_sigma_px == 0 || v <= 16);
                ASSERT_EQ(variance_px2(y, x), certain ? v : 0) << size << x << "," << y;
                ASSERT_EQ(published_px(y, x), certain ? d : range.invalid())
                    << size << x << "," << y;
              }
          }
  });
  cv::setNumThreads(threads_before);
}

TEST(Variance, PublishesNothingInPlace) {
  cv::RNG rng(9);
  RandomFrame frame({20, 5}, kRange, rng);
  cv::Mat1f variance_px2;
  EXPECT_THROW(publish(frame.disparity_px, frame.evidence, kRange, VarianceParams(),
                       frame.disparity_px, variance_px2),
               std::invalid_argument);
}

}  // namespace
}  // namespace predictive_stereo
