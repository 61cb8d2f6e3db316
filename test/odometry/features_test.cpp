#include "odometry/features.h"

#include <gtest/gtest.h>

#include <opencv2/core/utility.hpp>

#include "odometry/corridor.h"

namespace predictive_stereo {
namespace {

cv::Mat1b texture() {
  cv::Mat1b image;
  testing::smoothTexture({640, 240}, 1, 2).convertTo(image, CV_8U);
  return image;
}

std::vector<cv::Point2f> detect(const cv::Mat1b& image, int count,
                                const std::vector<cv::Point2f>& taken = {}) {
  std::vector<cv::Point2f> corners;
  CornerDetector().detect(image, count, taken, 10, corners);
  return corners;
}

TEST(Features, SpreadOverTheWholeImage) {
  const auto corners = detect(texture(), 300);
  EXPECT_GT(corners.size(), 300u);
  EXPECT_LT(corners.size(), 800u);
  int quarters[4] = {};
  for (const cv::Point2f& c : corners) ++quarters[(c.x > 320) + 2 * (c.y > 120)];
  for (int quarter : quarters) EXPECT_GT(quarter, static_cast<int>(corners.size()) / 5);
}

TEST(Features, KeepTheirDistanceFromEachOtherAndFromTheBorder) {
  const auto corners = detect(texture(), 500);
  for (size_t i = 0; i < corners.size(); ++i) {
    EXPECT_TRUE(cv::Rect2f(10, 10, 620, 220).contains(corners[i]));
    for (size_t k = 0; k < i; ++k) {
      const cv::Point2f d = corners[i] - corners[k];
      // Corners are selected per cell, so those of two cells may be close.
      EXPECT_GT(d.dot(d), 0.f);
    }
  }
}

TEST(Features, LeaveRoomThatIsTaken) {
  const cv::Mat1b image = texture();
  const auto corners = detect(image, 300);
  const auto more = detect(image, 300, corners);
  EXPECT_LT(more.size(), corners.size() / 20);
}

TEST(Features, FoundInTheDark) {
  cv::Mat1b dark;
  texture().convertTo(dark, CV_8U, 0.25, 0);
  EXPECT_GT(detect(dark, 300).size(), 200u);
}

TEST(Features, NoneWhereThereIsNothing) {
  EXPECT_TRUE(detect(cv::Mat1b(240, 640, uchar{255}), 300).empty());
  EXPECT_TRUE(detect(cv::Mat1b(15, 640, uchar{128}), 300).empty());
}

TEST(Features, SameForAnyNumberOfThreads) {
  cv::setNumThreads(1);
  const auto expected = detect(texture(), 400);
  for (int threads : {2, 3, 7}) {
    cv::setNumThreads(threads);
    EXPECT_EQ(detect(texture(), 400), expected) << threads << " threads";
  }
  cv::setNumThreads(-1);
}

}  // namespace
}  // namespace predictive_stereo
