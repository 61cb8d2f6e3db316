/// Every kernel is bit-identical to the plain reference, on every target of this machine.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "imaging/half_image.h"
#include "matching/census.h"
#include "matching/matching_scenes.h"
#include "matching/reference_sgm.h"
#include "matching/search.h"
#include "matching/search_windows.h"
#include "predictive_stereo/matcher.h"
#include "predictive_stereo/simd_target.h"
#include "simd/simd_dispatch.h"

namespace predictive_stereo {
namespace {

constexpr CensusForm kForms[] = {CensusForm::k5x5, CensusForm::kCentreSymmetric9x5,
                                 CensusForm::kMixed9x5};
constexpr PathSet kPathSets[] = {PathSet::kStraight4, PathSet::kDiagonal4, PathSet::kAll8};

template <class T>
bool equal(const cv::Mat_<T>& a, const cv::Mat_<T>& b) {
  return a.size() == b.size() && cv::countNonZero(a != b) == 0;
}

/// Differences between the two, as text; empty: none.
std::string differences(const Match& match, const Match& expected) {
  std::string text;
  if (!equal(match.disparity_px, expected.disparity_px)) text += " disparity_px";
  if (!equal(match.ambiguity, expected.ambiguity)) text += " ambiguity";
  if (!equal(match.search_width, expected.search_width)) text += " search_width";
  return text;
}

std::string describe(const MatcherParams& params, cv::Size size) {
  std::ostringstream text;
  text << params.simd_target << " " << size << " min " << params.range.min_disparity << " count "
       << params.range.count << " census " << static_cast<int>(params.census) << " paths "
       << static_cast<int>(params.paths) << " p1 " << params.p1 << " p2 " << params.p2;
  return text.str();
}

Match referenceMatch(const TestPair& pair, const MatcherParams& params, double offset_px,
                     const SearchRanges* ranges = nullptr) {
  const PrincipalOffset offset(offset_px);
  SearchWindows windows;
  if (ranges)
    planSearchWindows(*ranges, params.range, offset.fraction_px > 0, pair.left.size(),
                      kScalarTarget, windows);
  else
    planFullSearch(params.range, pair.left.size(), windows);
  Match match;
  matchReference(pair.left, pair.right, params, offset, windows, match);
  match.search_width = windows.width;
  return match;
}

/// What is compared with the reference: all but "scalar" on large images, which would only run the
/// slow reference again.
std::vector<std::string> comparedTargets(cv::Size size) {
  std::vector<std::string> targets = availableSimdTargets();
  if (size.area() > 100000)
    targets.erase(std::remove(targets.begin(), targets.end(), "scalar"), targets.end());
  return targets;
}

void expectFullSearchEqualsReference(const TestPair& pair, MatcherParams params,
                                     double offset_px = 0) {
  const Match expected = referenceMatch(pair, params, offset_px);
  for (const std::string& target : comparedTargets(pair.left.size())) {
    params.simd_target = target;
    Match match;
    StereoMatcher(params).match(pair.left, pair.right, match, offset_px);
    EXPECT_EQ(differences(match, expected), "")
        << describe(params, pair.left.size()) << " offset " << offset_px;
  }
}

/// Ranges of every kind: narrow and wide, far apart and overlapping, outside the interval, single
/// empty ones and groups of empty ones.
SearchRanges randomRanges(cv::Size size, const DisparityRange& range, unsigned seed) {
  cv::RNG random(seed);
  SearchRanges ranges{cv::Mat1s(size), cv::Mat1s(size)};
  for (int y = 0; y < size.height; ++y) {
    int centre = random.uniform(range.min_disparity, range.max_disparity());
    int half = 3;
    for (int x = 0; x < size.width; ++x) {
      centre += random.uniform(-1, 2);
      if (random.uniform(0, 8) == 0) centre = random.uniform(-30, range.max_disparity() + 30);
      if (random.uniform(0, 12) == 0) half = random.uniform(0, 8);
      if (random.uniform(0, 40) == 0) half = random.uniform(-2, range.count);
      ranges.first(y, x) = static_cast<short>(centre - half);
      ranges.last(y, x) = static_cast<short>(centre + half);
    }
  }
  return ranges;
}

void expectReducedSearchEqualsReference(const TestPair& pair, MatcherParams params,
                                        const SearchRanges& ranges, double offset_px = 0) {
  const Match expected = referenceMatch(pair, params, offset_px, &ranges);
  for (const std::string& target : comparedTargets(pair.left.size())) {
    params.simd_target = target;
    Match match;
    StereoMatcher(params).match(pair.left, pair.right, ranges, match, offset_px);
    EXPECT_EQ(differences(match, expected), "")
        << describe(params, pair.left.size()) << " offset " << offset_px;
  }
}

TEST(Kernels, CensusFormsCompareWhatTheirNamesSay) {
  struct Counts {
    CensusForm form;
    int opposite, with_centre;
  };
  for (const auto& [form, opposite, with_centre] : {Counts{CensusForm::k5x5, 0, 24},
                                                    {CensusForm::kCentreSymmetric9x5, 22, 0},
                                                    {CensusForm::kMixed9x5, 12, 12}}) {
    std::set<std::tuple<int, int, int, int>> opposites, with_centres;
    for (const CensusComparison& c : censusPattern(form)) {
      EXPECT_LE(std::abs(c.first_x), form == CensusForm::k5x5 ? 2 : 4);
      EXPECT_LE(std::abs(c.first_y), 2);
      if (c.first_x == 0 && c.first_y == 0) continue;  // no comparison
      const bool is_opposite = c.second_x == -c.first_x && c.second_y == -c.first_y;
      const bool is_with_centre = c.second_x == 0 && c.second_y == 0;
      EXPECT_TRUE(is_opposite || is_with_centre);
      if (form == CensusForm::kMixed9x5 && is_with_centre) {
        EXPECT_EQ((c.first_x + c.first_y) % 2, 0);
      }
      (is_opposite ? opposites : with_centres)
          .emplace(c.first_x, c.first_y, c.second_x, c.second_y);
    }
    EXPECT_EQ(opposites.size(), static_cast<size_t>(opposite));
    EXPECT_EQ(with_centres.size(), static_cast<size_t>(with_centre));
  }
}

TEST(Kernels, CensusEqualsReference) {
  cv::RNG random(1);
  for (const cv::Size size : {cv::Size(1, 1), {3, 1}, {1, 9}, {17, 4}, {64, 7}, {131, 9}}) {
    cv::Mat1b image(size);
    random.fill(image, cv::RNG::UNIFORM, 0, 256);
    for (const CensusForm form : kForms) {
      cv::Mat1i expected, words;
      censusReference(image, form, expected);
      for (const std::string& target : availableSimdTargets()) {
        if (target == "scalar") continue;
        CensusKernel(form, simdTargetBit(target)).transform(image, words);
        EXPECT_TRUE(equal(words, expected)) << target << size << static_cast<int>(form);
      }
    }
  }
}

TEST(Kernels, HalvedImagesHoldMeansOfFourPixels) {
  cv::RNG random(15);
  for (const cv::Size size : {cv::Size(2, 2), {3, 5}, {66, 8}, {257, 31}}) {
    cv::Mat1b image(size), half;
    random.fill(image, cv::RNG::UNIFORM, 0, 256);
    halveImage(image, half);
    ASSERT_EQ(half.size(), size / 2);
    for (int y = 0; y < half.rows; ++y)
      for (int x = 0; x < half.cols; ++x) {
        const int sum = image(2 * y, 2 * x) + image(2 * y, 2 * x + 1) + image(2 * y + 1, 2 * x) +
                        image(2 * y + 1, 2 * x + 1);
        ASSERT_EQ(half(y, x), (sum + 2) / 4) << size;
      }
  }
}

TEST(Kernels, FullSearchOfEveryPathSetCensusFormAndCount) {
  const TestPair pair = makeTestPair({75, 12}, 0, 30, 2);
  for (const PathSet paths : kPathSets)
    for (const CensusForm census : kForms)
      for (int count = 16; count <= 256; count += 16) {
        MatcherParams params;
        params.range.count = count;
        params.paths = paths;
        params.census = census;
        expectFullSearchEqualsReference(pair, params);
      }
}

TEST(Kernels, FullSearchOfEverySize) {
  for (const cv::Size size :
       {cv::Size(1, 1), {1, 40}, {2, 3}, {15, 2}, {31, 3}, {33, 1}, {64, 1}, {127, 20}, {200, 31}})
    for (const PathSet paths : kPathSets)
      for (const int min_disparity : {-16, 0, 16}) {
        MatcherParams params;
        params.range = {min_disparity, 64};
        params.paths = paths;
        expectFullSearchEqualsReference(makeTestPair(size, min_disparity, min_disparity + 20, 3),
                                        params);
      }
}

TEST(Kernels, SearchesOfCameraSizes) {
  for (const cv::Size size : {cv::Size(1242, 375), {1226, 370}, {2048, 1088}}) {
    MatcherParams params;
    params.range.count = size.width < 2000 ? 64 : 16;
    const TestPair pair = makeTestPair(size, 0, 40, 13);
    expectFullSearchEqualsReference(pair, params);
    expectReducedSearchEqualsReference(pair, params, randomRanges(size, params.range, 14));
  }
}

TEST(Kernels, FullSearchOfEveryPenalty) {
  const TestPair pair = makeTestPair({90, 30}, 0, 30, 4);
  for (const auto& [p1, p2] : {std::pair(1, 2), {6, 65}, {12, 80}, {100, 220}, {200, 201}})
    for (const int tolerance : {-1, 0, 2}) {
      MatcherParams params;
      params.range.count = 48;
      params.paths = PathSet::kAll8;
      params.p1 = p1;
      params.p2 = p2;
      params.left_right_tolerance_px = tolerance;
      expectFullSearchEqualsReference(pair, params);
    }
}

TEST(Kernels, FullSearchOfNoise) {
  TestPair pair = makeTestPair({120, 20}, 0, 30, 5);
  cv::RNG random(6);
  random.fill(pair.left, cv::RNG::UNIFORM, 0, 256);
  for (const PathSet paths : kPathSets)
    for (const int count : {128, 256}) {
      MatcherParams params;
      params.range.count = count;
      params.paths = paths;
      params.census = CensusForm::k5x5;  // the most comparisons: the largest costs
      expectFullSearchEqualsReference(pair, params);
    }
}

TEST(Kernels, ReducedSearchOfEveryPathSetCensusFormAndCount) {
  const TestPair pair = makeTestPair({131, 14}, 0, 30, 7);
  for (const PathSet paths : kPathSets)
    for (const CensusForm census : kForms)
      for (int count = 16; count <= 256; count += 48) {
        MatcherParams params;
        params.range.count = count;
        params.paths = paths;
        params.census = census;
        expectReducedSearchEqualsReference(pair, params,
                                           randomRanges(pair.left.size(), params.range, count));
      }
}

TEST(Kernels, ReducedSearchOfEverySize) {
  for (const cv::Size size :
       {cv::Size(1, 1), {1, 40}, {2, 3}, {15, 2}, {31, 3}, {33, 1}, {64, 1}, {127, 20}, {200, 31}})
    for (const PathSet paths : kPathSets)
      for (const int min_disparity : {-16, 0, 16}) {
        MatcherParams params;
        params.range = {min_disparity, 64};
        params.paths = paths;
        expectReducedSearchEqualsReference(makeTestPair(size, min_disparity, min_disparity + 20, 8),
                                           params, randomRanges(size, params.range, 9));
      }
}

TEST(Kernels, ReducedSearchOfEveryPenalty) {
  const TestPair pair = makeTestPair({90, 30}, 0, 30, 10);
  for (const auto& [p1, p2] : {std::pair(1, 2), {6, 65}, {12, 80}, {100, 220}, {200, 201}})
    for (const int tolerance : {-1, 0, 2}) {
      MatcherParams params;
      params.range.count = 96;
      params.paths = PathSet::kAll8;
      params.p1 = p1;
      params.p2 = p2;
      params.left_right_tolerance_px = tolerance;
      expectReducedSearchEqualsReference(pair, params,
                                         randomRanges(pair.left.size(), params.range, 11));
    }
}

TEST(Kernels, SearchesWithEveryPrincipalOffset) {
  for (const cv::Size size : {cv::Size(3, 2), {64, 3}, {131, 14}})
    for (const double offset_px : {-200.0, -150.4, -63.5, -37.4, -1.0, 0.5, 12.25, 101.7, 200.0})
      for (const PathSet paths : kPathSets)
        for (const int min_disparity : {-16, 0, 16}) {
          MatcherParams params;
          params.range = {min_disparity, 80};
          params.paths = paths;
          if (!leavesPartners(params.range, offset_px, size.width)) continue;  // no search
          const auto lowest = static_cast<int>(offset_px) + min_disparity;
          const TestPair pair = makeTestPair(size, lowest, lowest + 20, 7);
          expectFullSearchEqualsReference(pair, params, offset_px);
          expectReducedSearchEqualsReference(pair, params, randomRanges(size, params.range, 3),
                                             offset_px);
        }
}

TEST(Kernels, SearchesOfEveryEdgePenalty) {
  const TestPair pair = makeTestPair({90, 30}, 0, 30, 10);
  for (const auto& [edge_step, p2_edge] : {std::pair(0, 18), {1, 1}, {8, 30}, {40, 20}, {12, 200}})
    for (const PathSet paths : kPathSets) {
      MatcherParams params;
      params.range.count = 96;
      params.paths = paths;
      params.edge_step = edge_step;
      params.p2_edge = p2_edge;
      expectFullSearchEqualsReference(pair, params);
      expectReducedSearchEqualsReference(pair, params,
                                         randomRanges(pair.left.size(), params.range, 11));
    }
}

/// Calls the reduced search directly, because StereoMatcher would use the full search.
Match searchEverythingReduced(const TestPair& pair, const MatcherParams& params) {
  const int64_t target = simdTargetBit(params.simd_target);
  CensusKernel census(params.census, target);
  cv::Mat1i left_words, right_words;
  census.transform(pair.left, left_words);
  census.transform(pair.right, right_words);
  SearchWindows windows;
  planFullSearch(params.range, pair.left.size(), windows);
  const cv::Size size = pair.left.size();
  Match match{cv::Mat1f(size), cv::Mat1b(size), windows.width};
  AlignedBuffer volume;
  JumpFloors floors;
  floors.build(pair.left, params);
  ReducedSearch(params, target)
      .match(left_words, right_words, PrincipalOffset(0), floors, windows, volume, match);
  return match;
}

TEST(Kernels, ReducedSearchOfEverythingIsTheFullSearch) {
  const TestPair pair = makeTestPair({150, 40}, 0, 60, 12);
  for (const std::string& target : availableSimdTargets())
    for (const PathSet paths : kPathSets)
      for (const int count : {16, 64, 128, 256}) {
        MatcherParams params;
        params.simd_target = target;
        params.paths = paths;
        params.range.count = count;
        StereoMatcher matcher(params);
        Match full, reduced;
        matcher.match(pair.left, pair.right, full);
        const SearchRanges everything{cv::Mat1s(pair.left.size(), short{0}),
                                      cv::Mat1s(pair.left.size(), static_cast<short>(count - 1))};
        matcher.match(pair.left, pair.right, everything, reduced);
        EXPECT_EQ(differences(reduced, full), "") << describe(params, pair.left.size());
        if (target == "scalar") continue;
        EXPECT_EQ(differences(searchEverythingReduced(pair, params), full), "")
            << describe(params, pair.left.size());
      }
}

}  // namespace
}  // namespace predictive_stereo
