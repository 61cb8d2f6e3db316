/// Pairs whose principal points differ: the matcher searches the columns that its range means, and
/// no image is moved.
#include "matching/principal_offset.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "matching/matching_scenes.h"
#include "predictive_stereo/coarse_matcher.h"
#include "predictive_stereo/matcher.h"
#include "predictive_stereo/row_alignment.h"
#include "predictive_stereo/simd_target.h"

namespace predictive_stereo {
namespace {

const cv::Size kSize(330, 40);
constexpr int kLowest = 3, kHighest = 40;  // disparities of the scene

MatcherParams params(const std::string& simd_target) {
  MatcherParams params;
  params.range = {0, 64};
  params.simd_target = simd_target;
  return params;
}

SearchRanges aroundTruth(const TestPair& pair, int added_px) {
  SearchRanges ranges;
  cv::Mat1i(pair.disparity_px + (added_px - 3)).convertTo(ranges.first, CV_16S);
  cv::Mat1i(pair.disparity_px + (added_px + 3)).convertTo(ranges.last, CV_16S);
  return ranges;
}

void expectMoved(const Match& match, const DisparityRange& range, const Match& plain,
                 const DisparityRange& plain_range) {
  const int moved_px = plain_range.min_disparity - range.min_disparity;
  EXPECT_LT(cv::norm(match.disparity_px, plain.disparity_px - moved_px, cv::NORM_INF), 1e-4);
  EXPECT_EQ(cv::norm(match.ambiguity, plain.ambiguity, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(match.search_width, plain.search_width, cv::NORM_INF), 0);
  EXPECT_GT(cv::countNonZero(match.disparity_px >= range.min_disparity), 0);
}

// The same columns are compared if the range is moved instead.
TEST(PrincipalOffset, WholePixelsMoveTheRange) {
  for (const std::string& target : availableSimdTargets())
    for (const int offset_px : {-200, -37, 1, 101, 200}) {
      SCOPED_TRACE(target + " " + std::to_string(offset_px));
      const TestPair pair = makeTestPair(kSize, kLowest + offset_px, kHighest + offset_px, 5);
      MatcherParams moved = params(target);
      moved.range.min_disparity = offset_px;
      Match match, plain;
      StereoMatcher(params(target)).match(pair.left, pair.right, match, offset_px);
      StereoMatcher(moved).match(pair.left, pair.right, plain);
      expectMoved(match, params(target).range, plain, moved.range);
      StereoMatcher(params(target))
          .match(pair.left, pair.right, aroundTruth(pair, -offset_px), match, offset_px);
      StereoMatcher(moved).match(pair.left, pair.right, aroundTruth(pair, 0), plain);
      expectMoved(match, params(target).range, plain, moved.range);
    }
}

TEST(PrincipalOffset, FractionsAreSubtracted) {
  const TestPair pair = makeTestPair(kSize, kLowest, kHighest, 5);
  for (const std::string& target : availableSimdTargets())
    for (const float fraction_px : {0.25F, 0.7F}) {
      Match match, whole;
      StereoMatcher matcher(params(target));
      matcher.match(pair.left, pair.right, match, -1 + fraction_px);
      matcher.match(pair.left, pair.right, whole, -1);
      int known = 0;
      for (int y = 0; y < kSize.height; ++y)
        for (int x = 0; x < kSize.width; ++x) {
          const float whole_px = whole.disparity_px(y, x);
          const float expected_px = whole_px < 0 ? -1 : std::max(whole_px - fraction_px, 0.0F);
          ASSERT_NEAR(match.disparity_px(y, x), expected_px, 1e-6) << target << ' ' << x;
          known += whole_px >= 0;
        }
      EXPECT_GT(known, kSize.area() / 2);
    }
}

// Points at infinity have disparity 0, which a range that begins there must reach.
TEST(PrincipalOffset, TheFarEndOfTheRangeIsSearched) {
  for (const double offset_px : {-20.0, -19.75, -19.5, -19.01}) {
    const PrincipalOffset offset(offset_px);
    EXPECT_LE(offset.whole_px, offset_px + 1e-3);
    EXPECT_NEAR(offset.whole_px + offset.fraction_px, offset_px, 2e-3);
    EXPECT_GE(offset.fraction_px, 0);
    EXPECT_LT(offset.fraction_px, 1);
  }
  // Errors of rounding do not cost a pixel of the range.
  EXPECT_EQ(PrincipalOffset(12 - 1e-9).whole_px, 12);
  EXPECT_EQ(PrincipalOffset(12 - 1e-9).fraction_px, 0);
  const TestPair pair = makeTestPair(kSize, -20, -20, 5);
  Match match;
  StereoMatcher(params("auto")).match(pair.left, pair.right, match, -19.5);
  const cv::Mat1f inside = match.disparity_px.colRange(5, kSize.width - 30);
  EXPECT_EQ(cv::countNonZero(inside != 0), 0);  // -0.5 px is nearest to 0
}

TEST(PrincipalOffset, RangesAreSearchedToTheirEnds) {
  const TestPair pair = makeTestPair(kSize, 20, 20, 5);
  SearchRanges ranges{cv::Mat1s(kSize, short{5}), cv::Mat1s(kSize, short{19})};
  ranges.first.colRange(100, 200).setTo(8);
  ranges.last.colRange(100, 200).setTo(7);  // nothing
  MatcherParams exact = params("auto");
  exact.exact_ranges = true;
  Match match;
  StereoMatcher(exact).match(pair.left, pair.right, ranges, match, 0.75);
  EXPECT_EQ(match.search_width(20, 50), 16);
  EXPECT_EQ(match.search_width(20, 150), 0);
  EXPECT_NEAR(match.disparity_px(20, 50), 19.25, 0.01);
  EXPECT_LT(match.disparity_px(20, 150), 0);
}

TEST(PrincipalOffset, OfTheHalfResolutionIsHalf) {
  for (const double offset_px : {-37.0, 12.0, 101.0}) {
    const auto whole_px = static_cast<int>(offset_px);
    const TestPair pair =
        makeTestPair({kSize.width, 2 * kSize.height}, kLowest + whole_px, kHighest + whole_px, 5);
    cv::Mat1f coarse_px;
    CoarseMatcher(params("auto")).match(pair.left, pair.right, coarse_px, offset_px);
    double sum_px = 0;
    int known = 0, visible = 0;
    for (int y = 0; y < coarse_px.rows; ++y)
      for (int x = 0; x < coarse_px.cols; ++x) {
        const int truth_px = pair.disparity_px(2 * y, 2 * x);
        if (2 * x - truth_px < 8 || 2 * x - truth_px >= kSize.width - 8) continue;
        ++visible;
        const double error_px = coarse_px(y, x) + offset_px - truth_px;
        if (coarse_px(y, x) < 0 || std::abs(error_px) > 2) continue;
        ++known;
        sum_px += error_px;
      }
    EXPECT_GT(known, 0.85 * visible) << offset_px;
    EXPECT_LT(std::abs(sum_px / known), 0.25) << offset_px;  // without the fraction: 1 px
  }
}

TEST(PrincipalOffset, RowsAreComparedWhereThePartnersAre) {
  constexpr int kOffsetPx = 60;
  const TestPair pair = makeTestPair({500, 200}, kLowest + kOffsetPx, kHighest + kOffsetPx, 5);
  cv::Mat1b lower;
  cv::copyMakeBorder(pair.right.rowRange(0, 199), lower, 1, 0, 0, 0, cv::BORDER_REPLICATE);
  cv::Mat1f truth_px(100, 250);
  for (int y = 0; y < truth_px.rows; ++y)
    for (int x = 0; x < truth_px.cols; ++x)
      truth_px(y, x) = static_cast<float>(pair.disparity_px(2 * y, 2 * x) - kOffsetPx);
  RowAlignmentParams row_params;
  row_params.min_samples = 12;
  const RowOffsetModel rows =
      RowAligner(row_params).estimate(pair.left, lower, truth_px, {0, 64}, kOffsetPx);
  ASSERT_FALSE(rows.isIdentity());
  EXPECT_NEAR(rows.offset(250, 100, {500, 200}), 1, 0.1);
}

TEST(PrincipalOffset, NothingIsFoundBeyondTheImage) {
  const TestPair pair = makeTestPair(kSize, kLowest, kHighest, 5);
  const SearchRanges ranges = aroundTruth(pair, 0);
  for (const double offset_px :
       {330.0, -394.0, 1e6, -1e6, 1e300, std::numeric_limits<double>::infinity(),
        std::numeric_limits<double>::quiet_NaN()})
    for (const std::string& target : availableSimdTargets())
      for (const int tolerance_px : {-1, 2}) {
        MatcherParams unchecked = params(target);
        unchecked.left_right_tolerance_px = tolerance_px;
        StereoMatcher matcher(unchecked);
        for (const bool reduced : {false, true}) {
          Match match;
          if (reduced)
            matcher.match(pair.left, pair.right, ranges, match, offset_px);
          else
            matcher.match(pair.left, pair.right, match, offset_px);
          EXPECT_EQ(cv::countNonZero(match.disparity_px != -1), 0) << offset_px;
          EXPECT_EQ(cv::countNonZero(match.ambiguity != 255), 0) << offset_px;
          EXPECT_EQ(cv::countNonZero(match.search_width), 0) << offset_px;
        }
      }
}

}  // namespace
}  // namespace predictive_stereo
