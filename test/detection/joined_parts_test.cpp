#include "detection/joined_parts.h"

#include <gtest/gtest.h>

namespace predictive_stereo {
namespace {

constexpr double kMaxWidth_m = 9;
constexpr float kCar_px = 25, kBehind_px = 5;  // 10 m, 50 m

struct Scene {
  StereoRig rig;
  DisparityRange range;
  cv::Mat1f disparity_px;
  std::vector<ObservedObject> objects;

  Scene() {
    rig.size = {400, 300};
    rig.fx_px = rig.fy_px = 500;
    rig.cx_left_px = rig.cx_right_px = 200;
    rig.cy_px = 150;
    rig.baseline_m = 0.5;
    disparity_px = cv::Mat1f(rig.size, kBehind_px);
  }

  Observation& add(const cv::Rect& box, const Eigen::Vector3d& velocity_mps,
                   float part_px = kCar_px) {
    disparity_px(box) = part_px;
    ObservedObject object;
    object.mask = cv::Mat1b(box.size(), 255);
    Observation& seen = object.observation;
    seen.box_px = box;
    seen.distance_m = rig.disparityTimesDepth() / part_px;
    seen.size_m = Eigen::Vector3d(box.width, box.height, 0) * seen.distance_m / rig.fx_px;
    seen.has_velocity = true;
    seen.velocity_mps = velocity_mps;
    seen.velocity_covariance = 0.1 * Eigen::Matrix3d::Identity();
    objects.push_back(object);
    return objects.back().observation;
  }

  void join() { joinParts(rig, range, disparity_px, kMaxWidth_m, objects); }
};

const Eigen::Vector3d kForward(0, 0, 8), kAlmostForward(0.3, 0, 8.2);

TEST(JoinedParts, AreOneWithTheBoxAndMaskOfBoth) {
  Scene scene;
  scene.disparity_px(cv::Rect(100, 100, 150, 60)) = kCar_px;
  scene.add({100, 100, 20, 60}, kForward);
  scene.add({190, 110, 60, 50}, kAlmostForward);
  scene.join();
  ASSERT_EQ(scene.objects.size(), 1u);
  const ObservedObject& all = scene.objects[0];
  EXPECT_EQ(all.observation.box_px, cv::Rect(100, 100, 150, 60));
  EXPECT_EQ(all.observation.velocity_mps, kAlmostForward) << "the larger part's";
  EXPECT_EQ(cv::countNonZero(all.mask), 20 * 60 + 60 * 50);
  EXPECT_NEAR(all.observation.size_m.x(), 3.0, 0.4);
  EXPECT_NEAR(all.observation.distance_m, 10, 1e-6);
}

TEST(JoinedParts, MayHaveSomethingNearerBetweenThem) {
  Scene scene;
  scene.add({100, 100, 20, 60}, kForward);
  scene.add({150, 100, 20, 60}, kForward);
  scene.disparity_px(cv::Rect(115, 0, 40, 300)) = 40.0f;
  scene.join();
  EXPECT_EQ(scene.objects.size(), 1u);
}

TEST(JoinedParts, ThreeOfThem) {
  Scene scene;
  scene.disparity_px(cv::Rect(40, 100, 220, 60)) = kCar_px;
  scene.add({40, 100, 20, 60}, kForward);
  scene.add({240, 100, 20, 60}, kForward);  // too far from the first one alone
  scene.add({140, 100, 20, 60}, kForward);
  scene.join();
  ASSERT_EQ(scene.objects.size(), 1u);
  EXPECT_EQ(scene.objects[0].observation.box_px, cv::Rect(40, 100, 220, 60));
}

TEST(JoinedParts, AreApartWhereTheBackgroundIsSeenBetweenThem) {
  Scene scene;
  scene.add({100, 100, 20, 60}, kForward);
  scene.add({150, 100, 20, 60}, kForward);
  scene.join();
  EXPECT_EQ(scene.objects.size(), 2u);
}

TEST(JoinedParts, AreApartWhereTheyMoveDifferently) {
  Scene scene;
  scene.disparity_px(cv::Rect(100, 100, 150, 60)) = kCar_px;
  scene.add({100, 100, 20, 60}, kForward);
  scene.add({190, 110, 60, 50}, {0, 0, 5});
  scene.join();
  EXPECT_EQ(scene.objects.size(), 2u);
}

TEST(JoinedParts, AreApartWhereAVelocityIsNotKnown) {
  Scene scene;
  scene.disparity_px(cv::Rect(100, 100, 150, 60)) = kCar_px;
  scene.add({100, 100, 20, 60}, kForward);
  scene.add({190, 110, 60, 50}, kForward).has_velocity = false;
  scene.join();
  EXPECT_EQ(scene.objects.size(), 2u);
}

TEST(JoinedParts, AreApartInDepth) {
  Scene scene;
  scene.add({100, 100, 40, 60}, kForward);
  scene.add({140, 100, 40, 60}, kForward, 15);  // 16.7 m: the one that follows
  scene.join();
  EXPECT_EQ(scene.objects.size(), 2u);
}

TEST(JoinedParts, AreNoWiderThanARoadUser) {
  Scene scene;
  scene.disparity_px(cv::Rect(0, 100, 390, 60)) = 15.0f;  // 16.7 m
  scene.add({0, 100, 180, 60}, kForward, 15);
  scene.add({200, 100, 190, 60}, kForward, 15);
  scene.join();
  EXPECT_EQ(scene.objects.size(), 2u);
}

}  // namespace
}  // namespace predictive_stereo
