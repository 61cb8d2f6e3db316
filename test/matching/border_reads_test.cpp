/// Images, ranges and maps of every size beside a guard page (guarded_memory.h), on every SIMD
/// target: matching does not access memory beyond them, and its results are the same.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "guarded_memory.h"
#include "imaging/half_image.h"
#include "matching/matching_scenes.h"
#include "matching/row_offset_sample.h"
#include "matching/search_windows.h"
#include "predictive_stereo/coarse_matcher.h"
#include "predictive_stereo/matcher.h"
#include "predictive_stereo/row_alignment.h"
#include "predictive_stereo/simd_target.h"

namespace predictive_stereo {
namespace {

using testing::Guard;
using testing::GuardedRow;
using testing::GuardEveryMat;
using testing::kMostGuarded;

constexpr Guard kGuards[] = {Guard::kBehind, Guard::kBefore};
constexpr CensusForm kForms[] = {CensusForm::k5x5, CensusForm::kCentreSymmetric9x5,
                                 CensusForm::kMixed9x5};
constexpr PathSet kPathSets[] = {PathSet::kStraight4, PathSet::kDiagonal4, PathSet::kAll8};

template <class T>
bool equal(const cv::Mat_<T>& a, const cv::Mat_<T>& b) {
  return a.size() == b.size() && (a.empty() || cv::countNonZero(a != b) == 0);
}

// Ranges of all widths, different in every run of pixels.
SearchRanges rangesOfAllWidths(cv::Size size, const DisparityRange& range) {
  SearchRanges ranges{cv::Mat1s(size), cv::Mat1s(size)};
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      ranges.first(y, x) = static_cast<short>(range.min_disparity + (7 * x + 3 * y) % range.count);
      ranges.last(y, x) = static_cast<short>(ranges.first(y, x) + (x / 4 * 5 + y) % range.count);
    }
  return ranges;
}

// All results of matching a pair, as one list of maps.
std::vector<cv::Mat> mapsOf(cv::Size size, const MatcherParams& params, double offset_px) {
  const TestPair pair = makeTestPair(size, 0, 12, 7);
  const SearchRanges ranges = rangesOfAllWidths(size, params.range);
  Match full, reduced;
  StereoMatcher matcher(params);
  matcher.match(pair.left, pair.right, full, offset_px);
  matcher.match(pair.left, pair.right, ranges, reduced, offset_px);
  std::vector<cv::Mat> maps = {full.disparity_px,    full.ambiguity,    full.search_width,
                               reduced.disparity_px, reduced.ambiguity, reduced.search_width};
  if (size.width > 1 && size.height > 1) {
    cv::Mat1f coarse_px;
    CoarseMatcher(params).match(pair.left, pair.right, coarse_px, offset_px);
    maps.push_back(coarse_px);
  }
  return maps;
}

void expectNoReadsBeyond(cv::Size size, const MatcherParams& params, double offset_px) {
  const std::vector<cv::Mat> expected = mapsOf(size, params, offset_px);
  for (const Guard guard : kGuards) {
    const GuardEveryMat guards(guard);
    const std::vector<cv::Mat> maps = mapsOf(size, params, offset_px);
    ASSERT_EQ(maps.size(), expected.size());
    for (size_t i = 0; i < maps.size(); ++i)
      ASSERT_EQ(cv::norm(maps[i], expected[i], cv::NORM_INF), 0)
          << params.simd_target << ' ' << size << " offset " << offset_px << " map " << i;
  }
}

TEST(BorderReads, OfMatchedImages) {
  for (const cv::Size size : {cv::Size(1, 1), {2, 3}, {5, 2}, {19, 3}, {47, 6}, {66, 5}, {131, 7}})
    for (const CensusForm form : kForms)
      for (const PathSet paths : kPathSets)
        for (const std::string& target : availableSimdTargets()) {
          MatcherParams params;
          params.range.min_disparity = size.width % 3 - 1;
          params.range.count = size.height % 2 == 0 ? 48 : 128;
          params.census = form;
          params.paths = paths;
          params.simd_target = target;
          expectNoReadsBeyond(size, params, 0);
          if (form == CensusForm::kCentreSymmetric9x5)
            for (const double offset_px : {-130.5, -7.25, 46.0, 129.75})
              expectNoReadsBeyond(size, params, offset_px);
        }
}

TEST(BorderReads, OfHalvedImages) {
  for (const Guard guard : kGuards) {
    const GuardEveryMat guards(guard);
    for (int width = 2; width < kMostGuarded; ++width) {
      const cv::Mat1b image(3, width, uchar{100});
      cv::Mat1b half;
      halveImage(image, half);
      ASSERT_TRUE(equal(half, cv::Mat1b(1, width / 2, uchar{100})));
    }
  }
}

TEST(BorderReads, OfPlannedWindows) {
  for (const Guard guard : kGuards) {
    const GuardedRow<int16_t> first(kMostGuarded, guard, -5, 130),
        last(kMostGuarded, guard, -5, 130);
    const GuardedRow<uint16_t> width(kMostGuarded, guard);
    for (const std::string& target : availableSimdTargets())
      for (int n = 1; n <= kMostGuarded; ++n) {
        std::vector<WindowRun> runs(static_cast<size_t>((n + kWindowRun - 1) / kWindowRun));
        planRow(simdTargetBit(target))(first(n), last(n), n, {0, 128}, runs.data(), width(n));
      }
  }
}

TEST(BorderReads, OfRowOffsets) {
  const cv::Size size(61, 37);
  const TestPair pair = makeTestPair(size, 0, 12, 7);
  for (const Guard guard : kGuards) {
    const GuardEveryMat guards(guard);
    const cv::Mat1b left = pair.left.clone(), right = pair.right.clone();
    for (int y = -2; y < size.height + 2; ++y)
      for (int x = -2; x < size.width + 2; ++x)
        for (int disparity = -20; disparity <= 20; disparity += 4) {
          double expected = -1, offset = -1;
          const bool found = measureRowOffset(pair.left, pair.right, {x, y}, disparity, expected);
          ASSERT_EQ(measureRowOffset(left, right, {x, y}, disparity, offset), found);
          ASSERT_EQ(offset, expected);
        }
  }
}

TEST(BorderReads, OfWarpedImages) {
  RowOffsetModel model;
  model.samples = 100;
  model.coefficients_px << 0.4, 1.7, -2.3, 0.6, 0.2, -0.9;
  for (const cv::Size size : {cv::Size(1, 1), {3, 2}, {63, 5}, {64, 9}, {131, 33}}) {
    const cv::Mat1b right = makeTestPair(size, 0, 4, 3).right;
    for (const double shift_px : {0.0, 0.3, -2.6, 200.0}) {
      cv::Mat1b expected;
      alignRightImage(right, model, shift_px, expected);
      for (const Guard guard : kGuards) {
        const GuardEveryMat guards(guard);
        cv::Mat1b aligned;
        alignRightImage(right.clone(), model, shift_px, aligned);
        EXPECT_TRUE(equal(aligned, expected)) << size << ' ' << shift_px;
      }
    }
  }
}

}  // namespace
}  // namespace predictive_stereo
