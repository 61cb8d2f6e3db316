#include "predictive_stereo/matcher.h"

#include <gtest/gtest.h>

#include <cmath>

#include "matching/matching_scenes.h"

namespace predictive_stereo {
namespace {

MatcherParams smallParams(int min_disparity, int count) {
  MatcherParams params;
  params.range = {min_disparity, count};
  return params;
}

SearchRanges uniformRanges(cv::Size size, int first, int last) {
  return {cv::Mat1s(size, static_cast<short>(first)), cv::Mat1s(size, static_cast<short>(last))};
}

void expectEqual(const Match& a, const Match& b) {
  EXPECT_EQ(cv::countNonZero(a.disparity_px != b.disparity_px), 0);
  EXPECT_EQ(cv::countNonZero(a.ambiguity != b.ambiguity), 0);
  EXPECT_EQ(cv::countNonZero(a.search_width != b.search_width), 0);
}

/// Share of valid pixels, and of those within 1 px of the truth.
struct Score {
  double density, correct;
};
Score score(const Match& match, const TestPair& pair, const DisparityRange& range) {
  int valid = 0, correct = 0;
  for (int y = 0; y < match.disparity_px.rows; ++y)
    for (int x = 0; x < match.disparity_px.cols; ++x) {
      if (!range.isValid(match.disparity_px(y, x))) continue;
      ++valid;
      correct += std::abs(match.disparity_px(y, x) - pair.disparity_px(y, x)) <= 1;
    }
  return {valid / double(match.disparity_px.total()), correct / std::max(1.0, double(valid))};
}

TEST(Matcher, FindsTheDisparitiesOfEveryPathSetAndCensusForm) {
  for (const int min_disparity : {-16, 0, 16}) {
    const TestPair pair = makeTestPair({160, 90}, min_disparity + 3, min_disparity + 40, 1);
    for (const PathSet paths : {PathSet::kStraight4, PathSet::kDiagonal4, PathSet::kAll8})
      for (const CensusForm census :
           {CensusForm::k5x5, CensusForm::kCentreSymmetric9x5, CensusForm::kMixed9x5}) {
        MatcherParams params = smallParams(min_disparity, 48);
        params.paths = paths;
        params.census = census;
        Match match;
        StereoMatcher(params).match(pair.left, pair.right, match);
        const Score result = score(match, pair, params.range);
        EXPECT_GT(result.density, 0.6);
        EXPECT_GT(result.correct, 0.9) << static_cast<int>(paths) << static_cast<int>(census);
        EXPECT_EQ(cv::countNonZero(match.search_width != 48), 0);
      }
  }
}

// If the images hardly agree, the sum of 8 path costs exceeds a byte.
TEST(Matcher, EightPathsFindNoLessThanFourInNoise) {
  TestPair pair = makeTestPair({200, 120}, 10, 10, 7);
  cv::RNG random(8);
  cv::Mat1b noise(pair.left.size());
  random.fill(noise, cv::RNG::UNIFORM, 0, 160);
  cv::addWeighted(pair.left, 0.08, noise, 0.92, 0, pair.left);
  MatcherParams params = smallParams(0, 32);
  params.p1 = 20;
  params.p2 = 120;
  params.edge_step = 0;  // noise has edges everywhere
  const auto scoreOf = [&](PathSet paths, const SearchRanges* ranges) {
    params.paths = paths;
    StereoMatcher matcher(params);
    Match match;
    if (ranges)
      matcher.match(pair.left, pair.right, *ranges, match);
    else
      matcher.match(pair.left, pair.right, match);
    return score(match, pair, params.range);
  };
  const SearchRanges narrow = uniformRanges(pair.left.size(), 4, 17);
  for (const SearchRanges* ranges : {static_cast<const SearchRanges*>(nullptr), &narrow}) {
    const Score four = scoreOf(PathSet::kStraight4, ranges);
    const Score eight = scoreOf(PathSet::kAll8, ranges);
    EXPECT_GT(four.density, 0.7);
    EXPECT_GT(eight.density, four.density);
    EXPECT_GT(eight.correct, four.correct);
  }
}

TEST(Matcher, RangesThatCoverEverythingGiveTheFullSearch) {
  const TestPair pair = makeTestPair({101, 40}, 0, 60, 2);
  for (const PathSet paths : {PathSet::kStraight4, PathSet::kDiagonal4, PathSet::kAll8}) {
    MatcherParams params = smallParams(0, 80);
    params.paths = paths;
    StereoMatcher matcher(params);
    Match full, reduced;
    matcher.match(pair.left, pair.right, full);
    matcher.match(pair.left, pair.right, uniformRanges(pair.left.size(), -1000, 1000), reduced);
    expectEqual(full, reduced);
  }
}

TEST(Matcher, RangesAroundTheTruthKeepTheResult) {
  const TestPair pair = makeTestPair({200, 80}, 2, 50, 3);
  const MatcherParams params = smallParams(0, 64);
  SearchRanges ranges = uniformRanges(pair.left.size(), 0, 0);
  for (int y = 0; y < ranges.first.rows; ++y)
    for (int x = 0; x < ranges.first.cols; ++x) {
      ranges.first(y, x) = static_cast<short>(pair.disparity_px(y, x) - 3);
      ranges.last(y, x) = static_cast<short>(pair.disparity_px(y, x) + 3);
    }
  Match match;
  StereoMatcher(params).match(pair.left, pair.right, ranges, match);
  // Runs of four pixels share a window, so those across a depth discontinuity must be wider.
  for (int y = 0; y < ranges.first.rows; ++y)
    for (int x = 0; x < ranges.first.cols; x += 4) {
      const cv::Rect run(x, y, 4, 1);
      double nearest, farthest;
      cv::minMaxLoc(pair.disparity_px(run), &farthest, &nearest);
      const bool fits = nearest - farthest + 7 <= 16;
      EXPECT_EQ(cv::countNonZero(match.search_width(run) != 16), fits ? 0 : 4) << run;
    }
  EXPECT_GT(score(match, pair, params.range).correct, 0.97);
}

TEST(Matcher, EmptyRangesGiveNothingAndStopNothingElse) {
  const TestPair pair = makeTestPair({120, 60}, 2, 30, 4);
  const MatcherParams params = smallParams(0, 48);
  SearchRanges ranges = uniformRanges(pair.left.size(), 0, 47);
  const cv::Rect hole(40, 20, 13, 11);
  ranges.first(hole).setTo(20);
  ranges.last(hole).setTo(19);
  ranges.last.col(0).setTo(-5);     // completely below the interval
  ranges.first.col(119).setTo(48);  // completely above it
  ranges.last.col(119).setTo(60);
  Match match;
  StereoMatcher(params).match(pair.left, pair.right, ranges, match);
  for (const cv::Rect unsearched : {hole, cv::Rect(0, 0, 1, 60), cv::Rect(119, 0, 1, 60)}) {
    EXPECT_EQ(cv::countNonZero(match.disparity_px(unsearched) != params.range.invalid()), 0);
    EXPECT_EQ(cv::countNonZero(match.search_width(unsearched)), 0);
    EXPECT_EQ(cv::countNonZero(match.ambiguity(unsearched) != 255), 0);
  }
  EXPECT_GT(score(match, pair, params.range).correct, 0.93);
}

TEST(Matcher, ExactRangesAreSearchedAndNothingElse) {
  const TestPair pair = makeTestPair({120, 60}, 2, 40, 5);
  MatcherParams params = smallParams(-16, 64);
  cv::RNG random(6);
  SearchRanges ranges = uniformRanges(pair.left.size(), 0, 0);
  for (int y = 0; y < ranges.first.rows; ++y)
    for (int x = 0; x < ranges.first.cols; ++x) {
      const int centre = cvRound(pair.disparity_px(y, x)) + random.uniform(-9, 10);
      ranges.first(y, x) = static_cast<short>(centre - random.uniform(0, 5));
      ranges.last(y, x) = static_cast<short>(centre + random.uniform(-1, 5));  // may be empty
    }
  const auto outside = [&](const Match& match) {
    int count = 0;
    for (int y = 0; y < ranges.first.rows; ++y)
      for (int x = 0; x < ranges.first.cols; ++x) {
        const float d = match.disparity_px(y, x);
        count += params.range.isValid(d) && (d < ranges.first(y, x) || d > ranges.last(y, x));
      }
    return count;
  };
  for (const PathSet paths : {PathSet::kStraight4, PathSet::kDiagonal4, PathSet::kAll8}) {
    params.paths = paths;
    Match widened, exact;
    params.exact_ranges = false;
    StereoMatcher(params).match(pair.left, pair.right, ranges, widened);
    EXPECT_GT(outside(widened), 100);
    params.exact_ranges = true;
    StereoMatcher(params).match(pair.left, pair.right, ranges, exact);
    EXPECT_EQ(outside(exact), 0);
    EXPECT_GT(score(exact, pair, params.range).density, 0.1);
    for (int y = 0; y < ranges.first.rows; ++y)
      for (int x = 0; x < ranges.first.cols; ++x) {
        const int first = std::max<int>(ranges.first(y, x), -16);
        const int last = std::min<int>(ranges.last(y, x), 47);
        EXPECT_EQ(exact.search_width(y, x), std::max(last - first + 1, 0));
      }
  }
}

TEST(Matcher, ExactRangesThatCoverEverythingGiveTheFullSearch) {
  const TestPair pair = makeTestPair({101, 40}, 0, 60, 2);
  MatcherParams params = smallParams(0, 80);
  params.exact_ranges = true;
  StereoMatcher matcher(params);
  SearchRanges ranges = uniformRanges(pair.left.size(), 0, 79);
  Match full, exact;
  matcher.match(pair.left, pair.right, full);
  matcher.match(pair.left, pair.right, ranges, exact);
  expectEqual(full, exact);
  // One narrow range switches to scalar code. Far from it nothing changes, because P2 is paid
  // there.
  ranges.first(0, 0) = ranges.last(0, 0) = 40;
  matcher.match(pair.left, pair.right, ranges, exact);
  EXPECT_EQ(exact.search_width(0, 0), 1);
  const cv::Rect far(60, 20, 41, 20);
  EXPECT_EQ(cv::countNonZero(full.disparity_px(far) != exact.disparity_px(far)), 0);
}

// Disparities beside the winner are no second candidates.
TEST(Matcher, AWinnerWithoutASecondCandidateIsAmbiguous) {
  const TestPair pair = makeTestPair({120, 60}, 20, 20, 5);
  MatcherParams params = smallParams(0, 48);
  params.exact_ranges = true;
  for (const int width : {1, 2, 3, 4, 5}) {
    const int first = 21 - (width + 1) / 2;  // 20 is in the middle
    Match match;
    StereoMatcher(params).match(pair.left, pair.right,
                                uniformRanges(pair.left.size(), first, first + width - 1), match);
    int alone = 0, certain = 0;
    for (int y = 10; y < 50; ++y)
      for (int x = 50; x < 110; ++x) {
        const int d = cvRound(match.disparity_px(y, x));
        const bool is_alone = params.range.isValid(match.disparity_px(y, x)) && d - first <= 1 &&
                              first + width - 1 - d <= 1;
        alone += is_alone;
        if (is_alone) {
          EXPECT_EQ(match.ambiguity(y, x), 255) << width << ": " << x << ", " << y;
        }
        certain += match.ambiguity(y, x) < 128;
      }
    EXPECT_EQ(alone > 2000, width < 4) << width;
    EXPECT_EQ(certain > 2000, width >= 4) << width;
  }
}

TEST(Matcher, WinnersThatLeftAndRightDisputeAreAmbiguous) {
  const TestPair pair = makeTestPair({300, 120}, 0, 60, 5);
  MatcherParams params = smallParams(0, 64);
  params.left_right_tolerance_px = 1;
  Match strict, tolerant;
  StereoMatcher(params).match(pair.left, pair.right, strict);
  params.left_right_tolerance_px = 20;
  StereoMatcher(params).match(pair.left, pair.right, tolerant);
  int disputed = 0;
  for (int y = 0; y < pair.left.rows; ++y)
    for (int x = 0; x < pair.left.cols; ++x) {
      ASSERT_EQ(tolerant.ambiguity(y, x), strict.ambiguity(y, x)) << x << " " << y;
      if (!params.range.isValid(tolerant.disparity_px(y, x)) ||
          params.range.isValid(strict.disparity_px(y, x)))
        continue;
      ++disputed;
      EXPECT_EQ(tolerant.ambiguity(y, x), 255) << x << " " << y;
    }
  EXPECT_GT(disputed, 50);
}

TEST(Matcher, ResultsAreNotChangedByLaterMatches) {
  const TestPair pair = makeTestPair({120, 60}, 2, 40, 5);
  MatcherParams params = smallParams(0, 48);
  for (const char* target : {"scalar", "auto"}) {
    params.simd_target = target;
    StereoMatcher matcher(params);
    Match reduced, full;
    matcher.match(pair.left, pair.right, uniformRanges(pair.left.size(), 10, 25), reduced);
    const Match before{reduced.disparity_px.clone(), reduced.ambiguity.clone(),
                       reduced.search_width.clone()};
    matcher.match(pair.left, pair.right, full);
    expectEqual(reduced, before);
  }
}

TEST(Matcher, RefusesWhatItCannotMatch) {
  MatcherParams params;
  params.range.count = 40;
  EXPECT_THROW(StereoMatcher{params}, std::invalid_argument);
  params.range.count = 272;
  EXPECT_THROW(StereoMatcher{params}, std::invalid_argument);
  params = MatcherParams();
  params.p2 = params.p1;
  EXPECT_THROW(StereoMatcher{params}, std::invalid_argument);
  params.p2 = 230;
  EXPECT_THROW(StereoMatcher{params}, std::invalid_argument);

  StereoMatcher matcher{MatcherParams()};
  Match match;
  const cv::Mat1b image(20, 30, uchar{7});
  EXPECT_THROW(matcher.match(cv::Mat1b(), cv::Mat1b(), match), std::invalid_argument);
  EXPECT_THROW(matcher.match(image, cv::Mat1b(20, 31), match), std::invalid_argument);
  EXPECT_THROW(matcher.match(image, image, uniformRanges({29, 20}, 0, 5), match),
               std::invalid_argument);
}

}  // namespace
}  // namespace predictive_stereo
