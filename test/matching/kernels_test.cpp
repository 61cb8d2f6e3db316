/// Every kernel equals the plain reference bit for bit, on every target of this machine.
#include <gtest/gtest.h>

#include <string>

#include "matching/census.h"
#include "matching/census_kernel.h"
#include "matching/matching_scenes.h"
#include "matching/reference_sgm.h"
#include "matching/search_windows.h"
#include "matching/simd_dispatch.h"
#include "predictive_stereo/matcher.h"
#include "predictive_stereo/simd_target.h"

namespace predictive_stereo {
namespace {

constexpr CensusForm kForms[] = {CensusForm::k5x5, CensusForm::kCentreSymmetric9x5,
                                 CensusForm::kCentreSymmetric9x7};
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
  if (!equal(match.cost, expected.cost)) text += " cost";
  if (!equal(match.at_range_border, expected.at_range_border)) text += " at_range_border";
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

Match referenceMatch(const TestPair& pair, const MatcherParams& params,
                     const SearchRanges* ranges = nullptr) {
  SearchWindows windows;
  if (ranges)
    planSearchWindows(*ranges, params.range, pair.left.size(), windows);
  else
    planFullSearch(params.range, pair.left.size(), windows);
  Match match;
  matchReference(pair.left, pair.right, params, windows, match);
  match.search_width = windows.width;
  return match;
}

void expectFullSearchEqualsReference(const TestPair& pair, MatcherParams params) {
  const Match expected = referenceMatch(pair, params);
  for (const std::string& target : availableSimdTargets()) {
    params.simd_target = target;
    Match match;
    StereoMatcher(params).match(pair.left, pair.right, match);
    EXPECT_EQ(differences(match, expected), "") << describe(params, pair.left.size());
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
      params.census = CensusForm::kCentreSymmetric9x7;
      expectFullSearchEqualsReference(pair, params);
    }
}

}  // namespace
}  // namespace predictive_stereo
