#include "detection/unseen_object.h"

#include <gtest/gtest.h>

namespace predictive_stereo {
namespace {

constexpr float kCar_px = 25, kBehind_px = 5;  // 10 m, 50 m

struct Scene {
  StereoRig rig;
  DisparityRange range;
  cv::Mat1f disparity_px;
  Observation car;
  cv::Mat1b mask;

  Scene() {
    rig.size = {400, 300};
    rig.fx_px = rig.fy_px = 500;
    rig.cx_left_px = rig.cx_right_px = 200;
    rig.cy_px = 150;
    rig.baseline_m = 0.5;
    disparity_px = cv::Mat1f(rig.size, kBehind_px);
    car.box_px = {100, 100, 80, 60};
    car.distance_m = rig.disparityTimesDepth() / kCar_px;
    car.size_m = {1.6, 1.2, 0.4};
  }
  bool isThere() { return isStillThere(rig, range, disparity_px, car, mask); }
};

TEST(UnseenObject, IsThereWhereMostOfItsBoxHasItsDisparity) {
  Scene scene;
  const cv::Rect shown(105, 100, 70, 60);
  scene.disparity_px(shown) = kCar_px;
  ASSERT_TRUE(scene.isThere());
  ASSERT_EQ(scene.mask.size(), scene.car.box_px.size());
  EXPECT_EQ(cv::countNonZero(scene.mask), shown.area());
  EXPECT_EQ(cv::countNonZero(scene.mask(shown - scene.car.box_px.tl())), shown.area());
}

TEST(UnseenObject, ReachesAsFarAsItsOwnDepth) {
  Scene scene;
  const auto rear_px = static_cast<float>(scene.rig.disparityTimesDepth() / 14);
  scene.disparity_px(scene.car.box_px) = rear_px;
  EXPECT_FALSE(scene.isThere());
  scene.car.size_m.z() = 4.2;
  EXPECT_TRUE(scene.isThere());
}

TEST(UnseenObject, IsGoneWhereTheBackgroundShows) {
  Scene scene;
  EXPECT_FALSE(scene.isThere());
  scene.disparity_px(cv::Rect(100, 100, 40, 60)) = kCar_px;  // half of it
  EXPECT_FALSE(scene.isThere());
}

TEST(UnseenObject, IsUnknownWhereLittleIsMatched) {
  Scene scene;
  scene.disparity_px(scene.car.box_px) = scene.range.invalid();
  scene.disparity_px(cv::Rect(100, 100, 30, 60)) = kCar_px;
  EXPECT_FALSE(scene.isThere());
}

// There the invalid value is close to the object's disparity.
TEST(UnseenObject, AtTheFarEndOfTheRange) {
  Scene scene;
  scene.range.min_disparity = 25;
  scene.disparity_px.setTo(scene.range.invalid());
  const cv::Rect shown(105, 100, 70, 60);
  scene.disparity_px(shown) = kCar_px;
  ASSERT_TRUE(scene.isThere());
  EXPECT_EQ(cv::countNonZero(scene.mask), shown.area());
}

TEST(UnseenObject, CutByTheBorderOrOutsideOfTheImage) {
  Scene scene;
  scene.car.box_px = {-40, 100, 80, 60};
  scene.disparity_px(cv::Rect(0, 100, 40, 60)) = kCar_px;
  ASSERT_TRUE(scene.isThere());
  EXPECT_EQ(scene.mask.size(), cv::Size(40, 60));
  scene.car.box_px = {-90, 100, 80, 60};
  EXPECT_FALSE(scene.isThere());
  scene.car.box_px = {380, 290, 80, 60};
  EXPECT_FALSE(scene.isThere());
}

}  // namespace
}  // namespace predictive_stereo
