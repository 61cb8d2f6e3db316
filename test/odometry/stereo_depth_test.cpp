#include "odometry/stereo_depth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>

#include "odometry/corridor.h"

namespace predictive_stereo {
namespace {

const cv::Size kSize(480, 200);

// A slanted surface: the disparity is `near_px` in the bottom row and `far_px` in the top row.
struct Pair {
  ImagePyramid left, right;
  double far_px, near_px, row_offset_px;

  Pair(double far, double near, double row_offset)
      : far_px(far), near_px(near), row_offset_px(row_offset) {
    constexpr int kFine = 4;
    const cv::Mat1f fine = testing::smoothTexture({2048, 1024}, 5, 2.0 * kFine);
    cv::Mat1f x_left(kSize), y_left(kSize), x_right(kSize), y_right(kSize);
    for (int y = 0; y < kSize.height; ++y)
      for (int x = 0; x < kSize.width; ++x) {
        x_left(y, x) = static_cast<float>(kFine * x);
        y_left(y, x) = static_cast<float>(kFine * y);
        const double row = y - row_offset;  // of the left image
        x_right(y, x) = static_cast<float>(kFine * (x + shift(row)));
        y_right(y, x) = static_cast<float>(kFine * row);
      }
    cv::Mat1f grey;
    cv::remap(fine, grey, x_left, y_left, cv::INTER_CUBIC, cv::BORDER_WRAP);
    left.build(cv::Mat1b(grey), 2);
    cv::remap(fine, grey, x_right, y_right, cv::INTER_CUBIC, cv::BORDER_WRAP);
    right.build(cv::Mat1b(grey), 2);
  }
  double shift(double row) const { return far_px + (near_px - far_px) * row / kSize.height; }
};

std::vector<cv::Point2f> grid() {
  std::vector<cv::Point2f> points;
  for (float y = 20; y <= 180; y += 19.7f)
    for (float x = 120; x <= 440; x += 21.3f) points.emplace_back(x, y);
  return points;
}

std::vector<StereoMatch> asMatches(const std::vector<cv::Point2f>& points) {
  std::vector<StereoMatch> matches(points.size());
  for (size_t i = 0; i < points.size(); ++i) matches[i].point = points[i];
  return matches;
}

void expectFound(const Pair& pair, const std::vector<cv::Point2f>& points,
                 const std::vector<StereoMatch>& matches) {
  size_t found = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    if (!matches[i].found) continue;
    ++found;
    const double error = matches[i].row_offset_px - pair.row_offset_px;
    EXPECT_NEAR(error, 0, 0.15);
    EXPECT_NEAR(matches[i].shift_px + matches[i].shift_by_row * error, pair.shift(points[i].y),
                0.15);
  }
  EXPECT_GT(found, 0.9 * points.size());
}

TEST(StereoDepth, FindsAnyShiftInRange) {
  const auto points = grid();
  for (const auto& [far, near] : {std::pair{5.3, 7.9}, {40.2, 44.1}, {90.0, 95.0}}) {
    std::vector<StereoMatch> matches = asMatches(points);
    const Pair pair(far, near, 0);
    matchStereo(pair.left, pair.right, RowOffsetModel(), StereoSearch(), matches);
    expectFound(pair, points, matches);
  }
}

TEST(StereoDepth, FindsPointsInOtherRows) {
  const auto points = grid();
  for (double row_offset : {-2.3, -0.6, 1.4, 2.8}) {
    std::vector<StereoMatch> matches = asMatches(points);
    const Pair pair(20, 26, row_offset);
    matchStereo(pair.left, pair.right, RowOffsetModel(), StereoSearch(), matches);
    expectFound(pair, points, matches);
  }
}

TEST(StereoDepth, FarPointsOfARigThatSquintsHaveNegativeShifts) {
  const auto points = grid();
  std::vector<StereoMatch> matches = asMatches(points);
  const Pair pair(-1.3, -1.0, 0);
  matchStereo(pair.left, pair.right, RowOffsetModel(), StereoSearch(), matches);
  expectFound(pair, points, matches);
}

TEST(StereoDepth, AWrongExpectationDoesNoHarm) {
  const auto points = grid();
  const Pair pair(30, 36, 0);
  for (float off : {0.7f, 15.f, -25.f}) {
    std::vector<StereoMatch> matches = asMatches(points);
    for (size_t i = 0; i < points.size(); ++i) {
      matches[i].expected = true;
      matches[i].shift_px = static_cast<float>(pair.shift(points[i].y)) + off;
    }
    matchStereo(pair.left, pair.right, RowOffsetModel(), StereoSearch(), matches);
    expectFound(pair, points, matches);
  }
}

TEST(StereoDepth, NothingIsFoundInAnEmptyImage) {
  Pair pair(30, 36, 0);
  pair.right.build(cv::Mat1b(kSize, uchar{255}), 2);
  const auto points = grid();
  std::vector<StereoMatch> matches = asMatches(points);
  matchStereo(pair.left, pair.right, RowOffsetModel(), StereoSearch(), matches);
  for (const StereoMatch& match : matches) EXPECT_FALSE(match.found);
}

TEST(StereoDepth, RepeatedStructureIsRefused) {
  cv::Mat1f fence(kSize);
  for (int y = 0; y < kSize.height; ++y)
    for (int x = 0; x < kSize.width; ++x)
      fence(y, x) = static_cast<float>(128 + 50 * std::sin(0.4 * x) + 30 * std::sin(0.3 * y));
  ImagePyramid image;
  image.build(cv::Mat1b(fence), 2);
  const auto points = grid();
  std::vector<StereoMatch> matches = asMatches(points);
  matchStereo(image, image, RowOffsetModel(), StereoSearch(), matches);
  for (const StereoMatch& match : matches) EXPECT_FALSE(match.found);
}

// Of 144 points those that are found on a fence whose bars differ by a share of the variance of all
// grey values.
int foundOnFence(double share) {
  cv::Mat1f fence(kSize);
  for (int y = 0; y < kSize.height; ++y)
    for (int x = 0; x < kSize.width; ++x)
      fence(y, x) = static_cast<float>(50 * std::sin(0.4 * x) + 30 * std::sin(0.3 * y));
  const double deviation = std::sqrt((50 * 50 + 30 * 30) / 2.0);
  const cv::Mat1f texture =
      testing::smoothTexture(kSize, 5, 2, deviation * std::sqrt(share / (1 - share)));
  ImagePyramid image;
  image.build(cv::Mat1b(fence + texture), 2);
  std::vector<StereoMatch> matches = asMatches(grid());
  matchStereo(image, image, RowOffsetModel(), StereoSearch(), matches);
  return static_cast<int>(std::count_if(matches.begin(), matches.end(),
                                        [](const StereoMatch& match) { return match.found; }));
}

// Where bars that hardly differ count, the motion is that of the wrong ones.
TEST(StereoDepth, BarsOfAFenceMustDiffer) {
  EXPECT_LT(foundOnFence(0.08), 25);
  EXPECT_GT(foundOnFence(0.2), 100);
}

}  // namespace
}  // namespace predictive_stereo
