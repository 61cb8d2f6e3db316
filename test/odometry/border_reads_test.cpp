/// Features at every border of an image beside a guard page (guarded_memory.h), at every scale, on
/// every SIMD target: memory outside the image is not read, and results do not depend on it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "guarded_memory.h"
#include "imaging/patch.h"
#include "imaging/tracking.h"
#include "odometry/block_kernel.h"
#include "odometry/features.h"
#include "odometry/stereo_depth.h"
#include "predictive_stereo/simd_target.h"

namespace predictive_stereo {
namespace {

using testing::forEveryGuardAndTarget;
using testing::Guard;
using testing::GuardEveryMat;

constexpr Guard kGuards[] = {Guard::kBehind, Guard::kBefore};
const std::vector<float> kScales = {0.6f, 0.7f, 0.83f, 0.97f, 1, 1.0001f, 1.1f, 1.27f, 1.45f, 1.6f};

cv::Mat1b noise(cv::Size size) {
  cv::Mat1b image(size);
  cv::RNG(5).fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

// A copy beside a guard page.
cv::Mat1b guarded(const cv::Mat1b& image, Guard guard) {
  const GuardEveryMat guards(guard);
  return image.clone();
}

// Centres for which samples `half` to both sides just reach, just miss and clearly miss the first
// and the last pixel of `size`: in steps of a tenth of a pixel, and of one unit in the last place.
std::vector<float> centresAtBorders(int size, float half) {
  std::vector<float> centres;
  for (const float border : {half, static_cast<float>(size - 1) - half}) {
    for (int i = -12; i <= 12; ++i) centres.push_back(border + 0.1f * static_cast<float>(i));
    float below = border, above = border;
    for (int i = 0; i < 4; ++i) {
      centres.push_back(below = std::nextafter(below, -1e9f));
      centres.push_back(above = std::nextafter(above, 1e9f));
    }
  }
  return centres;
}

template <class Check>
void onEveryPatchKernel(const Check& check) {
  for (const std::string& target : availableSimdTargets()) {
    SCOPED_TRACE(target);
    check(patchKernel(simdTargetBit(target)));
  }
}

// Patches around all pairs of columns and rows of centres.
void expectSamplesOfImageAlone(const PatchKernel& kernel, const cv::Mat1b& image,
                               const cv::Mat1b& large, float scale) {
  const float half = 0.5f * (kFramedSize - 1) * scale;
  // Clearly inside, or clearly outside, along one axis.
  const auto place = [half](float centre, int size) {
    const float slack = std::min(centre - half, static_cast<float>(size - 1) - (centre + half));
    return slack > 0.01f ? 1 : slack < -0.01f ? -1 : 0;
  };
  for (const float x : centresAtBorders(image.cols, half))
    for (const float y : centresAtBorders(image.rows, half)) {
      Patch patch(kernel), in_large(kernel);
      const bool sampled = patch.sample(image, {x, y}, scale);
      const int by_x = place(x, image.cols), by_y = place(y, image.rows);
      if (by_x != 0 && by_y != 0) {
        ASSERT_EQ(sampled, by_x > 0 && by_y > 0) << x << ' ' << y << " x" << scale;
      }
      if (!sampled) continue;
      ASSERT_TRUE(in_large.sample(large, {x, y}, scale));
      ASSERT_EQ(patch.covariance(), in_large.covariance()) << x << ' ' << y << " x" << scale;
    }
}

TEST(BorderReads, OfPatchesThatAreSampled) {
  for (const cv::Size size : {cv::Size(64, 48), {47, 31}, {33, 33}, {26, 61}, {18, 18}, {15, 15}}) {
    // The image is the upper left part of a larger one with other content.
    const cv::Mat1b large = noise(size + cv::Size(40, 40));
    for (const Guard guard : kGuards) {
      const cv::Mat1b image = guarded(large(cv::Rect(cv::Point(), size)), guard);
      onEveryPatchKernel([&](const PatchKernel& kernel) {
        for (const float scale : kScales) expectSamplesOfImageAlone(kernel, image, large, scale);
      });
    }
  }
}

TEST(BorderReads, OfPatchesThatAreFoundAgain) {
  const cv::Size size(50, 37);
  const cv::Mat1b large = noise(size + cv::Size(40, 40));
  constexpr float kHalf = 0.5f * (kPatchSize - 1);
  for (const Guard guard : kGuards) {
    const cv::Mat1b image = guarded(large(cv::Rect(cv::Point(), size)), guard);
    onEveryPatchKernel([&](const PatchKernel& kernel) {
      Patch patch(kernel);
      ASSERT_TRUE(patch.sample(image, {25, 18}));
      for (const float x : centresAtBorders(size.width, kHalf))
        for (const float y : centresAtBorders(size.height, kHalf)) {
          const Patch::Match match = patch.align(image, {x, y}, 1);
          if (match.correlation == 0) continue;
          const Patch::Match in_large = patch.align(large, {x, y}, 1);
          ASSERT_EQ(match.position, in_large.position);
          ASSERT_EQ(match.correlation, in_large.correlation);
        }
    });
  }
}

// Positions are predictions, so they can have any value.
TEST(BorderReads, OfNoPatchThatIsNowhere) {
  const cv::Mat1b image = guarded(noise({50, 37}), Guard::kBehind);
  Patch patch;
  ASSERT_TRUE(patch.sample(image, {25, 18}));
  const float nan = std::nanf(""), inf = INFINITY;
  for (const float bad : {nan, inf, -inf, 1e30f, -1e30f, 3e9f, -3e9f, 50.f, -1.f})
    for (const cv::Point2f centre : {cv::Point2f(bad, 18), {25, bad}, {bad, bad}}) {
      EXPECT_EQ(patch.align(image, centre, 5).correlation, 0) << centre;
      EXPECT_FALSE(patch.align(image, centre, 5).converged) << centre;
      for (const float scale : {1.f, 1.3f}) EXPECT_FALSE(Patch().sample(image, centre, scale));
    }
  for (const float scale : {nan, inf, -inf, 1e30f, -1.f, 4.f})
    EXPECT_FALSE(Patch().sample(image, {25, 18}, scale)) << scale;
}

// A feature on every other pixel of the first 20 and the last 20 of both axes.
std::vector<cv::Point2f> pointsAtBorders(cv::Size size) {
  std::vector<cv::Point2f> points;
  for (int y = 0; y < size.height; y += y % 3 + 1)
    for (int x = 0; x < size.width; x += x % 3 + 1)
      if (std::min({x, y, size.width - 1 - x, size.height - 1 - y}) < 20)
        points.emplace_back(static_cast<float>(x) + 0.37f, static_cast<float>(y) + 0.61f);
  return points;
}

TEST(BorderReads, OfTrackedPointsAndStereoMatches) {
  const cv::Size size(121, 87);
  cv::Mat1b texture = noise(size + cv::Size(3, 2));
  cv::GaussianBlur(texture, texture, {}, 1.5);
  const cv::Mat1b from = texture(cv::Rect({}, size)), to = texture(cv::Rect({3, 2}, size));
  RowOffsetModel no_offset;
  const auto run = [&](std::vector<Track>& tracks, std::vector<StereoMatch>& matches) {
    ImagePyramid first, second;
    first.build(from.clone(), 4);
    second.build(to.clone(), 4);
    trackPoints(first, second, tracks);
    matchStereo(first, second, no_offset, StereoSearch(), matches);
  };
  std::vector<Track> tracks;
  std::vector<StereoMatch> matches;
  for (const cv::Point2f point : pointsAtBorders(size)) {
    for (const float scale : kScales) {
      Track track;
      track.origin = track.position = point;
      track.scale = scale;
      tracks.push_back(track);
    }
    StereoMatch match;
    match.point = point;
    matches.push_back(match);
    match.expected = true;
    matches.push_back(match);
  }
  auto expected_tracks = tracks;
  auto expected_matches = matches;
  run(expected_tracks, expected_matches);
  EXPECT_GT(std::count_if(expected_tracks.begin(), expected_tracks.end(),
                          [](const Track& track) { return track.found; }),
            0);
  for (const Guard guard : kGuards) {
    const GuardEveryMat guards(guard);
    auto guarded_tracks = tracks;
    auto guarded_matches = matches;
    run(guarded_tracks, guarded_matches);
    for (size_t i = 0; i < tracks.size(); ++i) {
      ASSERT_EQ(guarded_tracks[i].found, expected_tracks[i].found) << tracks[i].origin;
      ASSERT_EQ(guarded_tracks[i].position, expected_tracks[i].position) << tracks[i].origin;
    }
    for (size_t i = 0; i < matches.size(); ++i) {
      ASSERT_EQ(guarded_matches[i].found, expected_matches[i].found) << matches[i].point;
      ASSERT_EQ(guarded_matches[i].shift_px, expected_matches[i].shift_px) << matches[i].point;
    }
  }
}

TEST(BorderReads, OfBlocksAlongARow) {
  for (const Guard guard : kGuards)
    for (const std::string& target : availableSimdTargets())
      for (int width = kBlockSize; width < 100; ++width) {
        // One row of blocks, up to its last one, without other memory.
        const cv::Mat1b image = guarded(noise({width, kBlockSize}), guard);
        const BlockAt row{image.data, image.step}, last{&image(0, width - kBlockSize), image.step};
        const int positions = width - kBlockSize + 1;
        std::vector<float> correlation(static_cast<size_t>(positions)), expected(correlation);
        blockKernel(simdTargetBit(target))(last, row, positions, correlation.data());
        referenceBlockKernel()(last, row, positions, expected.data());
        ASSERT_EQ(correlation, expected) << target << ' ' << width;
      }
}

TEST(BorderReads, OfCorners) {
  forEveryGuardAndTarget([](Guard guard) {
    for (int width = 1; width < 140; width += width < 20 ? 1 : 7)
      for (int height = 1; height < 20; height += 3) {
        const cv::Mat1b image = guarded(noise({width, height}), guard);
        FastCorners fast;
        fast.find(image, {0, 0, width, height}, 7);
        std::vector<FastCorner> corners;
        fast.append(20, corners);
        std::vector<cv::Point2f> points;
        CornerDetector().detect(image, 50, {}, 0, points);
      }
  });
}

}  // namespace
}  // namespace predictive_stereo
