#include "predictive_stereo/coarse_matcher.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <string>

#include "matching/matching_scenes.h"

namespace predictive_stereo {
namespace {

/// What the constructor says against these parameters; empty: nothing.
template <class Matcher>
std::string refusal(const MatcherParams& params) {
  try {
    const Matcher matcher(params);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(CoarseMatcher, FindsFullResolutionDisparities) {
  for (const int min_disparity : {-16, 0, 16}) {
    TestPair pair = makeTestPair({401, 121}, min_disparity + 30, min_disparity + 30, 1);
    cv::GaussianBlur(pair.left, pair.left, {5, 5}, 1.5);
    cv::GaussianBlur(pair.right, pair.right, {5, 5}, 1.5);
    MatcherParams params;
    params.range = {min_disparity, 64};
    cv::Mat1f disparity_px;
    CoarseMatcher(params).match(pair.left, pair.right, disparity_px);
    ASSERT_EQ(disparity_px.size(), cv::Size(200, 60));
    int valid = 0, correct = 0;
    for (const float disparity : disparity_px) {
      valid += params.range.isValid(disparity);
      correct += std::abs(disparity - static_cast<float>(min_disparity + 30)) < 0.5F;
    }
    EXPECT_GT(valid, 0.7 * disparity_px.total());
    EXPECT_GT(correct, 0.95 * valid);
  }
}

// A square of 24x24 px, 10 px nearer than the wall behind it.
TEST(CoarseMatcher, DropsSmallRegions) {
  TestPair pair = makeTestPair({400, 120}, 20, 20, 3);
  const cv::Rect square(200, 50, 24, 24);
  pair.right(square - cv::Point(20, 0)).clone().copyTo(pair.right(square - cv::Point(30, 0)));
  cv::GaussianBlur(pair.left, pair.left, {5, 5}, 1.5);
  cv::GaussianBlur(pair.right, pair.right, {5, 5}, 1.5);
  const auto nearPixels = [&](int min_region_px) {
    cv::Mat1f disparity_px;
    CoarseMatcher(MatcherParams(), min_region_px).match(pair.left, pair.right, disparity_px);
    const cv::Rect around(90, 15, 32, 32);
    return cv::countNonZero(cv::abs(disparity_px(around) - 30) < 1.5);
  };
  // It covers 576 px, 144 at half resolution, and loses its border in the aggregation.
  EXPECT_GT(nearPixels(0), 50);
  EXPECT_GT(nearPixels(100), 50);
  EXPECT_EQ(nearPixels(800), 0);
}

TEST(CoarseMatcher, DoesNotDependOnTheFullResolutionsCensus) {
  const TestPair pair = makeTestPair({400, 120}, 10, 40, 4);
  const auto match = [&](CensusForm census) {
    MatcherParams params;
    params.census = census;
    cv::Mat1f disparity_px;
    CoarseMatcher(params).match(pair.left, pair.right, disparity_px);
    return disparity_px;
  };
  const cv::Mat1f expected = match(CensusForm::k5x5);
  for (const CensusForm form : {CensusForm::kCentreSymmetric9x5, CensusForm::kMixed9x5})
    EXPECT_EQ(cv::countNonZero(match(form) != expected), 0);
}

TEST(CoarseMatcher, RefusesTheParametersThatStereoMatcherRefuses) {
  MatcherParams ragged, no_jumps, wide, unknown_target;
  ragged.range = {0, 40};
  no_jumps.p2 = no_jumps.p1;
  wide.range.count = 272;
  unknown_target.simd_target = "abacus";
  for (const MatcherParams& params : {ragged, no_jumps, wide, unknown_target}) {
    const std::string message = refusal<StereoMatcher>(params);
    EXPECT_NE(message, "");
    EXPECT_EQ(refusal<CoarseMatcher>(params), message);
  }
}

TEST(CoarseMatcher, RefusesWhatItCannotMatch) {
  CoarseMatcher matcher{MatcherParams()};
  cv::Mat1f disparity_px;
  const cv::Mat1b image(20, 30, uchar{7});
  EXPECT_THROW(matcher.match(cv::Mat1b(), cv::Mat1b(), disparity_px), std::invalid_argument);
  EXPECT_THROW(matcher.match(cv::Mat1b(1, 30), cv::Mat1b(1, 30), disparity_px),
               std::invalid_argument);
  EXPECT_THROW(matcher.match(image, cv::Mat1b(20, 31), disparity_px), std::invalid_argument);
}

}  // namespace
}  // namespace predictive_stereo
