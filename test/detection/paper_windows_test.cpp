#include "detection/paper_windows.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace predictive_stereo {
namespace {

std::vector<cv::Rect> naiveWindows(const cv::Mat1f& difference, const PaperDetectionParams& p,
                                   const std::vector<cv::Size>& sizes) {
  std::vector<cv::Rect> windows;
  for (cv::Size size : sizes)
    for (int y = 0; y < difference.rows; y += 1)
      for (int x = 0; x < difference.cols; x += p.step_px) {
        if (y < difference.rows * p.skipped_top) continue;
        if ((y - static_cast<int>(std::ceil(difference.rows * p.skipped_top))) % p.step_px)
          continue;
        const cv::Rect window(cv::Point(x, y), size);
        if ((window & cv::Rect({}, difference.size())) != window) continue;
        if (cv::sum(difference(window))[0] >= p.min_mean_difference_px * window.area())
          windows.push_back(window);
      }
  return windows;
}

double iou(const cv::Rect& a, const cv::Rect& b) {
  return static_cast<double>((a & b).area()) / (a.area() + b.area() - (a & b).area());
}

void naiveMerge(double min_iou, std::vector<cv::Rect>& boxes) {
  for (;;) {
    double best = -1;
    size_t bi = 0, bj = 0;
    for (size_t i = 0; i < boxes.size(); ++i)
      for (size_t j = i + 1; j < boxes.size(); ++j)
        if (iou(boxes[i], boxes[j]) > best) best = iou(boxes[i], boxes[j]), bi = i, bj = j;
    if (best < min_iou) return;
    boxes[bi] |= boxes[bj];
    boxes.erase(boxes.begin() + static_cast<std::ptrdiff_t>(bj));
  }
}

TEST(PaperWindows, EqualNaiveSums) {
  cv::RNG random(7);
  cv::Mat1f difference(120, 200);
  // Multiples of 1/4, so that sums are exact.
  for (float& value : difference) value = 0.25f * static_cast<float>(random.uniform(0, 9));
  difference(cv::Rect(90, 60, 40, 30)) += 2.0f;
  PaperDetectionParams params;
  params.window_sizes = 3;
  params.largest_window_width_px = 70;
  params.largest_window_height_px = 50;
  params.step_px = 3;
  for (double threshold : {0.9, 1.0, 1.1, 2.0, 2.9}) {
    params.min_mean_difference_px = threshold;
    EXPECT_EQ(movingWindows(difference, params),
              naiveWindows(difference, params, {{20, 20}, {45, 35}, {70, 50}}))
        << threshold;
  }
}

TEST(PaperWindows, MergeEqualsNaiveGreedyMerge) {
  for (uint64_t seed = 1; seed <= 60; ++seed) {
    cv::RNG random(seed);
    std::vector<cv::Rect> boxes;
    for (int i = random.uniform(0, 40); i > 0; --i)
      boxes.emplace_back(5 * random.uniform(0, 40), 5 * random.uniform(0, 20),
                         10 * random.uniform(2, 8), 10 * random.uniform(2, 6));
    std::vector<cv::Rect> expected = boxes;
    const double min_iou = random.uniform(0.01, 0.4);
    naiveMerge(min_iou, expected);
    mergeBoxes(min_iou, boxes);
    EXPECT_EQ(boxes, expected) << seed;
  }
}

TEST(PaperWindows, FindsOneBoxPerBlobInTheLowerTwoThirds) {
  cv::Mat1f difference = cv::Mat1f::zeros(300, 600);
  difference(cv::Rect(100, 150, 60, 40)) = 4.0f;
  difference(cv::Rect(400, 200, 50, 50)) = 4.0f;
  difference(cv::Rect(250, 20, 50, 50)) = 4.0f;  // in the upper third
  difference(cv::Rect(300, 200, 8, 8)) = 4.0f;   // too small for any window
  std::vector<cv::Rect> boxes = movingBoxes(difference, {});
  std::sort(boxes.begin(), boxes.end(), [](auto& a, auto& b) { return a.x < b.x; });
  ASSERT_EQ(boxes.size(), 2u);
  EXPECT_EQ(boxes[0] & cv::Rect(100, 150, 60, 40), cv::Rect(100, 150, 60, 40));
  EXPECT_EQ(boxes[1] & cv::Rect(400, 200, 50, 50), cv::Rect(400, 200, 50, 50));
}

// The time of merging grows with the square of the number of windows.
TEST(PaperWindows, ManyWindowsTakeALargerStep) {
  PaperDetectionParams params, twice = params;
  params.step_px = 2;
  twice.step_px = 4;
  cv::Mat1f difference = cv::Mat1f::zeros(300, 600);
  const cv::Rect near(203, 121, 90, 101);
  difference(near) = 4.0f;
  ASSERT_GT(movingWindows(difference, params).size(), 2000u);
  EXPECT_EQ(movingBoxes(difference, params), movingBoxes(difference, twice));
  ASSERT_EQ(movingBoxes(difference, params).size(), 1u);
  EXPECT_EQ(movingBoxes(difference, params)[0] & near, near);

  difference.setTo(4.0f);
  params.step_px = 1;
  EXPECT_EQ(movingBoxes(difference, params).size(), 1u);
}

TEST(PaperWindows, DropsSmallBoxes) {
  cv::Mat1f difference = cv::Mat1f::zeros(300, 600);
  difference(cv::Rect(100, 150, 20, 20)) = 1.6f;  // enough for only one window
  PaperDetectionParams params;
  EXPECT_TRUE(movingBoxes(difference, params).empty());
  params.min_width_px = params.min_height_px = 20;
  EXPECT_EQ(movingBoxes(difference, params).size(), 1u);
}

}  // namespace
}  // namespace predictive_stereo
