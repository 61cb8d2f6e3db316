#include "imaging/tracking.h"

#include <gtest/gtest.h>

#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>

#include "imaging/patch.h"
#include "odometry/corridor.h"

namespace predictive_stereo {
namespace {

constexpr int kLevels = 4;
const cv::Size kSize(400, 300);

// Two images of one texture; the second one is shifted, and scaled about the centre. Both are
// sampled from a finer original, so that neither is an interpolation of the other.
struct Pair {
  cv::Mat1b first, second;

  explicit Pair(cv::Point2d flow, double scale = 1) {
    constexpr int kFine = 4;
    const cv::Mat1f fine = testing::smoothTexture({2048, 2048}, 3, 2.0 * kFine, 25) +
                           testing::smoothTexture({2048, 2048}, 4, 12.0 * kFine, 35) - 128;
    const auto take = [&](cv::Point2d moved, double zoom) {
      // Image (x, y) has the value of the original at centre + kFine ((x, y) - middle - moved) /
      // zoom.
      const double s = kFine / zoom;
      const cv::Matx23d to_fine(s, 0, 1024 - s * (kSize.width / 2.0 + moved.x), 0, s,
                                1024 - s * (kSize.height / 2.0 + moved.y));
      cv::Mat1f grey;
      cv::warpAffine(fine, grey, to_fine, kSize, cv::INTER_CUBIC | cv::WARP_INVERSE_MAP);
      return cv::Mat1b(grey);
    };
    first = take({0, 0}, 1);
    second = take(flow, scale);
  }
};

std::vector<cv::Point2f> grid() {
  std::vector<cv::Point2f> points;
  for (float y = 90; y <= 210; y += 20.3f)
    for (float x = 90; x <= 310; x += 20.7f) points.emplace_back(x, y);
  return points;
}

std::vector<Track> follow(const Pair& pair, const std::vector<cv::Point2f>& points,
                          float scale = 1) {
  ImagePyramid from, to;
  from.build(pair.first, kLevels);
  to.build(pair.second, kLevels);
  std::vector<Track> tracks(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    tracks[i].origin = tracks[i].position = points[i];
    tracks[i].scale = scale;
  }
  trackPoints(from, to, tracks);
  return tracks;
}

double meanError(const std::vector<cv::Point2f>& points, const std::vector<Track>& tracks,
                 cv::Point2f flow) {
  double sum = 0;
  int found = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    if (!tracks[i].found) continue;
    sum += cv::norm(tracks[i].position - points[i] - flow);
    ++found;
  }
  EXPECT_GT(found, 0.9 * points.size());
  return sum / found;
}

TEST(Tracking, SubPixelShifts) {
  const auto points = grid();
  for (const cv::Point2d flow : {cv::Point2d(0.25, 0.5), {-0.4, 0.1}, {3.3, -2.7}})
    EXPECT_LT(meanError(points, follow(Pair(flow), points), flow), 0.02) << flow;
}

TEST(Tracking, FastRotationMovesTheImageByTensOfPixels) {
  const auto points = grid();
  const cv::Point2d flow(26.4, -7.8);
  EXPECT_LT(meanError(points, follow(Pair(flow), points), flow), 0.03);
}

TEST(Tracking, NothingMovesAtStandstill) {
  const auto points = grid();
  EXPECT_LT(meanError(points, follow(Pair({0, 0}), points), {0, 0}), 1e-4);
}

TEST(Tracking, ChangedExposureDoesNotMatter) {
  const auto points = grid();
  const cv::Point2d flow(2.6, 1.2);
  Pair pair(flow);
  pair.second.convertTo(pair.second, CV_8U, 0.7, 20);
  EXPECT_LT(meanError(points, follow(pair, points), flow), 0.03);
}

TEST(Tracking, ExpectedScaleKeepsPatchesExact) {
  const double scale = 1.15;  // objects ahead grow while driving
  const std::vector<cv::Point2f> points = grid();
  const auto tracks = follow(Pair({0, 0}, scale), points, static_cast<float>(1 / scale));
  double sum = 0;
  int found = 0;
  const cv::Point2f middle(200, 150);
  for (size_t i = 0; i < points.size(); ++i) {
    if (!tracks[i].found) continue;
    sum += cv::norm(tracks[i].position - middle - scale * (points[i] - middle));
    ++found;
  }
  EXPECT_GT(found, 0.9 * points.size());
  EXPECT_LT(sum / found, 0.03);
}

TEST(Tracking, NothingIsFoundInAnotherOrAnEmptyImage) {
  Pair pair({0, 0});
  cv::Mat1b other;
  testing::smoothTexture(kSize, 77, 2).convertTo(other, CV_8U);
  for (const cv::Mat1b& second :
       {other, cv::Mat1b(kSize, uchar{255}), cv::Mat1b(kSize, uchar{0})}) {
    pair.second = second;
    int found = 0;
    for (const Track& track : follow(pair, grid())) found += track.found;
    EXPECT_LT(found, 5);
  }
}

TEST(Tracking, PointsAtTheBorderAreRefusedNotRead) {
  const std::vector<cv::Point2f> points = {{0, 0}, {399, 299}, {2, 150}, {398.9f, 3}};
  for (const Track& track : follow(Pair({1, 1}), points)) EXPECT_FALSE(track.found);
}

TEST(Tracking, SameForAnyNumberOfThreads) {
  const auto points = grid();
  const Pair pair({1.7, -0.6});
  cv::setNumThreads(1);
  const auto expected = follow(pair, points);
  for (int threads : {2, 3, 7}) {
    cv::setNumThreads(threads);
    const auto tracks = follow(pair, points);
    for (size_t i = 0; i < points.size(); ++i) {
      EXPECT_EQ(tracks[i].position, expected[i].position);
      EXPECT_EQ(tracks[i].found, expected[i].found);
    }
  }
  cv::setNumThreads(-1);
}

TEST(Patch, AKnownRowCorrectsTheColumnOnAnObliqueEdge) {
  // Stripes at 45 degrees with a little texture: an error of the row gives the same error of the
  // column.
  cv::Mat1f stripes(60, 60);
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 60; ++x)
      stripes(y, x) =
          static_cast<float>(128 + 60 * std::sin(0.5 * (x + y)) + 8 * std::sin(0.5 * x));
  Patch patch;
  ASSERT_TRUE(patch.sample(cv::Mat1b(stripes), {30, 30}));
  EXPECT_NEAR(patch.columnErrorFromRowError(0.5), -0.5, 0.1);
}

}  // namespace
}  // namespace predictive_stereo
