#include "detection/grown_segment.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace predictive_stereo {
namespace {

constexpr float kLeastSmooth = -0.7f, kDecisive = 2.0f;

// A layer with a surface, of which motion has revealed a part.
struct Surface {
  cv::Mat1b layer = cv::Mat1b::zeros(60, 120), mask = cv::Mat1b::zeros(60, 120);
  cv::Mat1f support = cv::Mat1f::zeros(60, 120);

  Surface(const cv::Rect& surface, const cv::Rect& shown) {
    layer(surface) = 255;
    mask(shown) = 255;
    support(shown) = 5.0f;
  }
  bool grow() {
    cv::Mat1f smooth;
    cv::boxFilter(support, smooth, CV_32F, {5, 5});
    GrowingWork work;
    const cv::Mat1b before = mask.clone();
    growOverLayer(layer, support, smooth, kLeastSmooth, kDecisive, mask, work);
    return cv::countNonZero(mask != before) > 0;
  }
  cv::Rect box() const { return cv::boundingRect(mask); }
};

TEST(GrownSegment, ReachesTheEdgesOfItsSurface) {
  const cv::Rect car(20, 10, 80, 30);
  Surface surface(car, {30, 12, 30, 25});
  surface.layer(cv::Rect(104, 10, 16, 30)) = 255;  // beyond a gap: another surface
  EXPECT_TRUE(surface.grow());
  EXPECT_EQ(surface.box(), car);
  EXPECT_EQ(cv::countNonZero(surface.mask), car.area());
}

TEST(GrownSegment, DoesNotCrossAThinBridge) {
  Surface surface({20, 10, 40, 30}, {22, 12, 30, 25});
  surface.layer(cv::Rect(66, 10, 40, 30)) = 255;
  surface.layer(cv::Rect(60, 20, 6, 1)) = 255;
  EXPECT_TRUE(surface.grow());
  EXPECT_EQ(surface.box(), cv::Rect(20, 10, 40, 30));
}

TEST(GrownSegment, LeavesOutTheLittleThatContradicts) {
  Surface surface({20, 10, 80, 30}, {30, 12, 30, 25});
  const cv::Rect pole(95, 10, 5, 30);
  surface.support(pole) = -10.0f;
  EXPECT_TRUE(surface.grow());
  EXPECT_EQ(cv::countNonZero(surface.mask(pole)), 0);
  EXPECT_GE(surface.box().br().x, 90);
}

// A pedestrian before a static wall of about the same depth.
TEST(GrownSegment, StaysBeforeAWallThatStandsStill) {
  const cv::Rect shown(40, 20, 20, 30);
  Surface surface({0, 10, 120, 45}, shown);
  for (int y = 12; y < 50; y += 10)
    for (int x = 2; x < 110; x += 10)
      if (x < 35 || x > 65) surface.support(cv::Rect(x, y, 3, 3)) = -10.0f;
  EXPECT_FALSE(surface.grow());
  EXPECT_EQ(surface.box(), shown);
  EXPECT_EQ(cv::countNonZero(surface.mask), shown.area());
}

// The motion of a tiny part of a surface is not that of the surface.
TEST(GrownSegment, StaysWhereItIsATinyPart) {
  const cv::Rect shown(40, 20, 10, 10);
  Surface surface({0, 10, 120, 45}, shown);
  EXPECT_FALSE(surface.grow());
  EXPECT_EQ(surface.box(), shown);
}

TEST(GrownSegment, StaysWhereItsPartsLieInMoreThanOneSurface) {
  Surface surface({20, 10, 20, 30}, {25, 15, 10, 20});
  surface.layer(cv::Rect(60, 10, 20, 30)) = 255;
  surface.mask(cv::Rect(65, 15, 10, 20)) = 255;
  EXPECT_FALSE(surface.grow());
}

}  // namespace
}  // namespace predictive_stereo
