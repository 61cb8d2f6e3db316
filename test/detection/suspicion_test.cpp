/// Suspicion is identical to a plain reference, on every SIMD target.
#include "detection/suspicion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "every_target.h"
#include "passing_scene.h"

namespace predictive_stereo {
namespace {

cv::Mat1f textureOf(const cv::Mat1b& grey) {
  cv::Mat1f texture;
  greyTexture(grey, texture);
  return texture;
}

// Of a frame with these disparities.
std::vector<cv::Point> suspectsOf(FrameParts& parts, const cv::Mat1b& grey,
                                  const cv::Mat1f& mismatch, const cv::Mat1f& disparity_px) {
  parts.input.measured_disparity_px = disparity_px;
  if (parts.obstacles.standing.empty())
    parts.obstacles.standing = cv::Mat1b(grey.size(), uchar{255});
  return findSuspects(parts.frame, textureOf(grey), mismatch).points_px;
}

double meanAround(const cv::Mat1d& map, int v, int u) {
  return cv::mean(map(cv::Rect(u - 2, v - 2, 5, 5)))[0];
}

std::vector<cv::Point> reference(const cv::Mat1b& grey, const cv::Mat1f& mismatch, double least) {
  cv::Mat1d values = cv::Mat1d(grey), deviation(grey.size(), 0);
  for (int v = 2; v < grey.rows - 2; ++v)
    for (int u = 2; u < grey.cols - 2; ++u)
      deviation(v, u) = std::abs(values(v, u) - cvRound(meanAround(values, v, u)));
  std::vector<cv::Point> points;
  for (int v = 5; v + 4 + 5 <= grey.rows; v += 4)
    for (int u = 5; u + 4 + 5 <= grey.cols; u += 4) {
      double worst = 0;
      cv::Point at;
      for (int j = v; j < v + 4; ++j)
        for (int i = u; i < u + 4; ++i) {
          const double ratio = mismatch(j, i) / (meanAround(deviation, j, i) + 3);
          if (mismatch(j, i) >= 0 && ratio > worst) worst = ratio, at = {2 * i, 2 * j};
        }
      if (worst >= least) points.push_back(at);
    }
  return points;
}

TEST(Suspicion, FindsTheWorstPointOfEachCellAsTheReference) {
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(4, 30), cv::Size(13, 14), cv::Size(14, 13),
                              cv::Size(31, 15), cv::Size(150, 47), cv::Size(621, 188)}) {
    SCOPED_TRACE(size);
    cv::RNG rng(size.area());
    // Parts of larger maps, with low and full contrast.
    cv::Mat1b image(size.height + 2, size.width + 3);
    cv::Mat1f map(image.size());
    rng.fill(image, cv::RNG::UNIFORM, 100, 110);
    cv::Mat1b contrast = image.colRange(0, size.width / 3 + 1);
    rng.fill(contrast, cv::RNG::UNIFORM, 0, 2);
    contrast *= 255;
    rng.fill(map, cv::RNG::UNIFORM, -2, 30);
    const cv::Rect part(cv::Point(2, 1), size);
    const cv::Mat1b grey = image(part);
    const cv::Mat1f mismatch = map(part);
    const cv::Mat1f disparity(2 * grey.rows, 2 * grey.cols, 10.0f);
    for (const double least : {0.3, 4.9, 100.0}) {
      FrameParts parts;
      parts.params.min_mismatch = least;
      const std::vector<cv::Point> expected = reference(grey, mismatch, least);
      if (size.width > 600 && least < 1) {
        EXPECT_GT(expected.size(), 4000u);
      }
      forEveryTarget(
          [&] { EXPECT_EQ(suspectsOf(parts, grey, mismatch, disparity), expected) << least; });
    }
  }
}

TEST(Suspicion, LeavesEdgesOfDisparityOut) {
  const cv::Mat1b grey(100, 200, uchar{50});
  const cv::Mat1f mismatch(grey.size(), 20.0f);
  cv::Mat1f disparity(200, 400, 10.0f);
  disparity.colRange(104, 109).setTo(30.0f);  // a pole; of each cell, column 10 + 8 k is tried
  disparity.colRange(200, 300).setTo(30.0f);  // a car
  FrameParts parts;
  int on_pole = 0, on_car = 0;
  for (cv::Point p : suspectsOf(parts, grey, mismatch, disparity)) {
    on_pole += p.x >= 104 && p.x < 109;
    on_car += p.x >= 200 && p.x < 300;
  }
  EXPECT_EQ(on_pole, 0);
  EXPECT_GT(on_car, 200);
}

TEST(Suspicion, UnknownDisparitiesAreNoSurface) {
  FrameParts parts;
  parts.range = {10, 64};
  const cv::Mat1b grey(100, 200, uchar{50});
  const cv::Mat1f mismatch(grey.size(), 20.0f);
  cv::Mat1f disparity(200, 400, parts.range.invalid());
  disparity.colRange(104, 109).setTo(10.0f);
  EXPECT_TRUE(suspectsOf(parts, grey, mismatch, disparity).empty());
}

TEST(Suspicion, LeavesOutWhatDoesNotStand) {
  const cv::Mat1b grey(100, 200, uchar{50});
  const cv::Mat1f mismatch(grey.size(), 20.0f);
  FrameParts parts;
  parts.obstacles.standing = cv::Mat1b::zeros(grey.size());
  parts.obstacles.standing.rowRange(0, 60).setTo(255);
  int upright = 0;
  for (cv::Point p : suspectsOf(parts, grey, mismatch, cv::Mat1f(200, 400, 3.0f))) {
    EXPECT_LT(p.y, 120);
    ++upright;
  }
  EXPECT_GT(upright, 500);
}

// Some patches of noise resemble others by chance.
void expectMost(const std::vector<cv::Point>& found, const std::vector<cv::Point>& of) {
  EXPECT_GE(found.size(), 0.8 * static_cast<double>(of.size()));
  EXPECT_TRUE(std::includes(
      of.begin(), of.end(), found.begin(), found.end(),
      [](cv::Point a, cv::Point b) { return std::tie(a.y, a.x) < std::tie(b.y, b.x); }));
}

std::vector<cv::Point> unexplained(Passing& scene, const std::vector<cv::Point>& points_px) {
  return unexplainedPoints(scene.view(), points_px);
}

TEST(UnexplainedPoints, LeavesWhatStandsOut) {
  Passing scene;
  EXPECT_TRUE(unexplained(scene, pointsIn(kAll)).empty());
}

TEST(UnexplainedPoints, KeepsWhatMoves) {
  Passing scene;
  scene.move(kMover, 14);
  expectMost(unexplained(scene, pointsIn(kWithin)), pointsIn(kWithin));
}

TEST(UnexplainedPoints, AllowForDisparitiesThatAreOff) {
  Passing scene;
  scene.disparity += 1.4f;
  EXPECT_TRUE(unexplained(scene, pointsIn(kAll)).empty());
  scene.disparity += 6.0f;
  expectMost(unexplained(scene, pointsIn(kAll)), pointsIn(kAll));
  for (int y = 0; y < kHeight; y += 8) scene.disparity.row(y + 4).setTo(kWall_px);
  EXPECT_TRUE(unexplained(scene, pointsIn(kAll)).empty()) << "the right one is 4 px away";
}

TEST(UnexplainedPoints, AllowForAnotherExposure) {
  Passing scene;
  scene.now = 0.5 * scene.now;
  scene.before = 0.5 * scene.before + 60;
  EXPECT_TRUE(unexplained(scene, pointsIn(kAll)).empty());
}

TEST(UnexplainedPoints, LeavesWhatWasJustUncoveredOut) {
  Passing scene;
  scene.move(kMover, 14);
  scene.previous.disparity_px.setTo(3 * kWall_px);
  EXPECT_TRUE(unexplained(scene, pointsIn(kWithin)).empty());
  scene.previous.disparity_px.setTo(1.1f * kWall_px);
  EXPECT_FALSE(unexplained(scene, pointsIn(kWithin)).empty())
      << "it may have been that near itself";
}

TEST(UnexplainedPoints, UnknownDisparitiesHideNothing) {
  const DisparityRange all{0, 64}, range{static_cast<int>(kWall_px), 64};
  const std::vector<cv::Point> middle = {{kWidth / 2, kHeight / 2}};
  Passing scene;
  scene.move(kAll, 14);
  scene.T_prev_cam.translation() = Eigen::Vector3d(0, 0, 5);  // 15 m ahead, 20 m then
  scene.params.largest_speed_mps = 30;                        // what hides it may go 3 m farther
  scene.previous.disparity_px.setTo(range.invalid());
  scene.range = all;
  EXPECT_TRUE(unexplained(scene, middle).empty());
  scene.range = range;
  EXPECT_EQ(unexplained(scene, middle), middle);
}

TEST(UnexplainedPoints, LooksAtAnEvenSample) {
  Passing scene;
  scene.move(kMover, 14);
  const std::vector<cv::Point> some = unexplained(scene, pointsIn(kWithin));
  ASSERT_GT(some.size(), 30u);
  std::vector<cv::Point> many;
  while (many.size() < 4200) many.insert(many.end(), some.begin(), some.end());
  const std::vector<cv::Point> kept = unexplained(scene, many);
  ASSERT_EQ(kept.size(), (many.size() + 1) / 2);
  for (size_t i = 0; i < kept.size(); ++i) EXPECT_EQ(kept[i], many[2 * i]);
  EXPECT_TRUE(unexplained(scene, {}).empty());
}

}  // namespace
}  // namespace predictive_stereo
