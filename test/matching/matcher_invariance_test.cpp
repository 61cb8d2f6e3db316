/// Results must not depend on threads, on views into larger images, or on earlier calls of a
/// matcher. There must be no allocations while frames keep their size.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <stdexcept>

#include "matching/matching_scenes.h"
#include "predictive_stereo/coarse_matcher.h"
#include "predictive_stereo/matcher.h"
#include "predictive_stereo/simd_target.h"

// The sanitizers replace the allocation functions.
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define COUNTS_ALLOCATIONS
/// Only allocations of this size or more are counted, because thread pools make smaller ones.
constexpr size_t kCountedBytes = 1024;
std::atomic<int> large_allocations{0};

extern "C" {
void* __libc_malloc(size_t);
void* __libc_memalign(size_t, size_t);
void* malloc(size_t size) {
  large_allocations += size >= kCountedBytes;
  return __libc_malloc(size);
}
void* aligned_alloc(size_t alignment, size_t size) {
  large_allocations += size >= kCountedBytes;
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** memory, size_t alignment, size_t size) {
  large_allocations += size >= kCountedBytes;
  *memory = __libc_memalign(alignment, size);
  return *memory ? 0 : 12;
}
}
#endif

namespace predictive_stereo {
namespace {

bool equal(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && cv::countNonZero(a != b) == 0;
}
bool equal(const Match& a, const Match& b) {
  return equal(a.disparity_px, b.disparity_px) && equal(a.ambiguity, b.ambiguity) &&
         equal(a.search_width, b.search_width);
}

/// Around the truth, with some wide ranges and some empty ones.
SearchRanges rangesAround(const TestPair& pair) {
  SearchRanges ranges{cv::Mat1s(pair.left.size()), cv::Mat1s(pair.left.size())};
  for (int y = 0; y < pair.left.rows; ++y)
    for (int x = 0; x < pair.left.cols; ++x) {
      const int half = x % 53 == 0 ? 40 : x % 31 == 0 ? -1 : 3;
      ranges.first(y, x) = static_cast<short>(pair.disparity_px(y, x) - half);
      ranges.last(y, x) = static_cast<short>(pair.disparity_px(y, x) + half);
    }
  return ranges;
}

class MatcherInvariance : public ::testing::TestWithParam<PathSet> {
 protected:
  void SetUp() override {
    params_.range.count = 64;
    params_.paths = GetParam();
  }
  void TearDown() override { cv::setNumThreads(-1); }

  const TestPair pair_ = makeTestPair({203, 77}, 2, 50, 1);
  const SearchRanges ranges_ = rangesAround(pair_);
  MatcherParams params_;
};

TEST_P(MatcherInvariance, ThreadsDoNotChangeResults) {
  Match full, reduced;
  cv::Mat1f coarse_px;
  for (const int threads : {1, 2, 3, 7}) {
    cv::setNumThreads(threads);
    StereoMatcher matcher(params_);
    Match other_full, other_reduced;
    cv::Mat1f other_coarse_px;
    matcher.match(pair_.left, pair_.right, other_full);
    matcher.match(pair_.left, pair_.right, ranges_, other_reduced);
    CoarseMatcher(params_).match(pair_.left, pair_.right, other_coarse_px);
    if (threads == 1) {
      full = other_full;
      reduced = other_reduced;
      coarse_px = other_coarse_px;
      continue;
    }
    EXPECT_TRUE(equal(other_full, full)) << threads;
    EXPECT_TRUE(equal(other_reduced, reduced)) << threads;
    EXPECT_TRUE(equal(other_coarse_px, coarse_px)) << threads;
  }
}

TEST_P(MatcherInvariance, ViewsIntoLargerImagesMatchLikeTheirCopies) {
  const cv::Rect view(11, 5, 150, 60);
  const SearchRanges part{ranges_.first(view), ranges_.last(view)};
  const SearchRanges copy{ranges_.first(view).clone(), ranges_.last(view).clone()};
  StereoMatcher matcher(params_);
  Match of_view, of_copy;
  matcher.match(pair_.left(view), pair_.right(view), of_view);
  matcher.match(pair_.left(view).clone(), pair_.right(view).clone(), of_copy);
  EXPECT_TRUE(equal(of_view, of_copy));
  matcher.match(pair_.left(view), pair_.right(view), part, of_view);
  matcher.match(pair_.left(view).clone(), pair_.right(view).clone(), copy, of_copy);
  EXPECT_TRUE(equal(of_view, of_copy));
}

TEST_P(MatcherInvariance, EarlierFramesDoNotChangeResults) {
  Match fresh, used;
  StereoMatcher(params_).match(pair_.left, pair_.right, ranges_, fresh);
  StereoMatcher matcher(params_);
  const TestPair larger = makeTestPair({301, 90}, 0, 60, 2),
                 smaller = makeTestPair({40, 9}, 0, 20, 3);
  matcher.match(larger.left, larger.right, used);
  matcher.match(smaller.left, smaller.right, rangesAround(smaller), used);
  matcher.match(larger.left, larger.right, rangesAround(larger), used);
  matcher.match(pair_.left, pair_.right, ranges_, used);
  EXPECT_TRUE(equal(used, fresh));
}

#ifdef COUNTS_ALLOCATIONS
TEST_P(MatcherInvariance, FramesOfOneSizeAllocateNothing) {
  StereoMatcher matcher(params_);
  CoarseMatcher coarse_matcher(params_);
  Match full, reduced;
  cv::Mat1f coarse_px;
  const auto frame = [&] {
    matcher.match(pair_.left, pair_.right, full);
    matcher.match(pair_.left, pair_.right, ranges_, reduced);
    coarse_matcher.match(pair_.left, pair_.right, coarse_px);
  };
  const int before_first = large_allocations;
  frame();
  EXPECT_GT(large_allocations, before_first) << "the counter does not count";
  // A thread allocates its buffers when it first gets a row to work on, in whichever frame.
  int frames_without = 0;
  for (int i = 0; i < 1000 && frames_without < 20; ++i) {
    const int before = large_allocations;
    frame();
    frames_without = large_allocations == before ? frames_without + 1 : 0;
  }
  EXPECT_EQ(frames_without, 20);
}
#endif

INSTANTIATE_TEST_SUITE_P(PathSets, MatcherInvariance,
                         ::testing::Values(PathSet::kStraight4, PathSet::kDiagonal4,
                                           PathSet::kAll8));

TEST(SimdTarget, IsChosenByNameOrEnvironment) {
  const std::vector<std::string> available = availableSimdTargets();
  ASSERT_FALSE(available.empty());
  EXPECT_EQ(available.back(), "scalar");
  MatcherParams params;
  for (const std::string& name : available) {
    params.simd_target = name;
    EXPECT_EQ(StereoMatcher(params).simdTarget(), name);
  }
  params.simd_target = "auto";
  unsetenv("PREDICTIVE_STEREO_SIMD");
  EXPECT_EQ(StereoMatcher(params).simdTarget(), available.front());
  setenv("PREDICTIVE_STEREO_SIMD", "scalar", 1);
  EXPECT_EQ(StereoMatcher(params).simdTarget(), "scalar");
  setenv("PREDICTIVE_STEREO_SIMD", "mmx", 1);
  EXPECT_THROW(StereoMatcher{params}, std::invalid_argument);
  unsetenv("PREDICTIVE_STEREO_SIMD");
  params.simd_target = "avx1024";
  try {
    StereoMatcher matcher(params);
    FAIL() << "accepted an unknown target";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("simd_target = avx1024"), std::string::npos);
  }
}

}  // namespace
}  // namespace predictive_stereo
