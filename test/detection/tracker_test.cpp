#include "detection/tracker.h"

#include <gtest/gtest.h>

#include <cmath>

namespace predictive_stereo {
namespace {

StereoRig testRig() {
  StereoRig rig;
  rig.size = {1240, 376};
  rig.fx_px = rig.fy_px = 720;
  rig.cx_left_px = rig.cx_right_px = 610;
  rig.cy_px = 170;
  rig.baseline_m = 0.54;
  return rig;
}

// A box of 2 m x 2 m whose centre is at this point of the camera frame.
Observation at(const StereoRig& rig, const Eigen::Vector3d& centre_m) {
  Observation seen;
  seen.centre_m = centre_m;
  seen.size_m = Eigen::Vector3d(2, 2, 1);
  seen.distance_m = centre_m.z() - 0.5;
  const Eigen::Vector3d p = rig.disparityFromPoint(centre_m);
  const double side = 2 * rig.fx_px / centre_m.z();
  seen.box_px =
      cv::Rect(cvRound(p.x() - side / 2), cvRound(p.y() - side / 2), cvRound(side), cvRound(side));
  seen.centre_covariance = Eigen::Vector3d(0.01, 0.01, 0.04).asDiagonal();
  seen.score = 0.95;
  return seen;
}

TEST(ObjectTracker, FollowsThroughTheCamerasMotion) {
  const StereoRig rig = testRig();
  ObjectTracker tracker{TrackingParams(), 40};
  const Eigen::Vector3d velocity(-6, 0, -8);
  int id = 0;
  for (int k = 0; k < 15; ++k) {
    const double t = 0.1 * k;
    Eigen::Isometry3d T_odom_cam = Eigen::Isometry3d::Identity();
    T_odom_cam.translation() = Eigen::Vector3d(0, 0, 10 * t);
    T_odom_cam.rotate(Eigen::AngleAxisd(0.1 * t, Eigen::Vector3d::UnitY()));
    tracker.predict(t, rig, T_odom_cam);
    const Eigen::Vector3d in_odom = Eigen::Vector3d(8, 0, 40) + t * velocity;
    tracker.update({at(rig, T_odom_cam.inverse() * in_odom)});
    ASSERT_EQ(tracker.tracks().size(), 1u) << k;
    const ObjectTrack& track = tracker.tracks()[0];
    if (k == 0) id = track.id;
    EXPECT_EQ(track.id, id);
    EXPECT_EQ(track.confirmed, k >= 1);
    EXPECT_EQ(track.age, k + 1);
  }
  const DetectedObject object = tracker.describe(tracker.tracks()[0]);
  EXPECT_LT((object.velocity_mps - velocity).norm(), 0.3);
  // The error is consistent with the covariance.
  const Eigen::Vector3d error = object.velocity_mps - velocity;
  EXPECT_LT(error.dot(object.velocity_covariance.inverse() * error), 16);
}

// A car ahead brakes. Its velocities are measured well, but as means over 0.8 s: they lag.
TEST(ObjectTracker, KnowsThatMeanVelocitiesLag) {
  const StereoRig rig = testRig();
  const double braking_mps2 = 2, span_s = 0.8;
  const auto ahead_m = [&](double t) { return 10 + 15 * t - 0.5 * braking_mps2 * t * t; };
  ObjectTracker tracker{TrackingParams(), 40};
  tracker.predict(-0.1, rig, Eigen::Isometry3d::Identity());
  for (int k = 0; k < 20; ++k) {
    const double t = 0.1 * k;
    tracker.predict(t, rig, Eigen::Isometry3d::Identity());
    Observation seen = at(rig, {0, 0, ahead_m(t)});
    seen.has_velocity = true;
    seen.velocity_span_s = span_s;
    seen.velocity_mps.z() = (ahead_m(t) - ahead_m(t - span_s)) / span_s;
    seen.velocity_covariance.diagonal().setConstant(0.05 * 0.05);
    tracker.update({seen});
    const DetectedObject object = tracker.describe(tracker.tracks()[0]);
    const double error_mps = object.velocity_mps.z() - (15 - braking_mps2 * t);
    EXPECT_GT(error_mps, 0.1) << k;
    EXPECT_LT(error_mps, 3 * std::sqrt(object.velocity_covariance(2, 2))) << k;
    EXPECT_LT(std::sqrt(object.velocity_covariance(2, 2)), 1) << k;
  }
}

// Frames until an object with this side and score is confirmed.
int framesUntilConfirmed(const TrackingParams& params, int side_px, double score) {
  const StereoRig rig = testRig();
  ObjectTracker tracker{params, 40};
  Observation seen = at(rig, {0, 0, 20});
  seen.box_px = cv::Rect(100, 100, side_px, side_px);
  seen.score = score;
  for (int k = 1; k < 20; ++k) {
    tracker.predict(0.1 * k, rig, Eigen::Isometry3d::Identity());
    tracker.update({seen});
    if (tracker.tracks().at(0).confirmed) return k;
  }
  return 20;
}

TEST(ObjectTracker, ConfirmsByTheEvidenceOfAllFrames) {
  TrackingParams params;
  // A frame's evidence is ln(score / (1 - score)) + ln(side^2 / 1000).
  EXPECT_EQ(framesUntilConfirmed(params, 200, 0.6), 2);  // 4.09
  EXPECT_EQ(framesUntilConfirmed(params, 60, 0.95), 2);  // 4.23
  EXPECT_EQ(framesUntilConfirmed(params, 40, 0.85), 3);  // 2.20
  EXPECT_EQ(framesUntilConfirmed(params, 20, 0.95), 3);  // 2.03
  EXPECT_EQ(framesUntilConfirmed(params, 15, 1), 3);     // 1.98 instead of infinity
  EXPECT_EQ(framesUntilConfirmed(params, 20, 0.5), 20);  // negative
  params.confirm_evidence = 4;
  EXPECT_EQ(framesUntilConfirmed(params, 20, 0.95), 2);
  params.confirm_frames = 1;
  EXPECT_EQ(framesUntilConfirmed(params, 200, 0.6), 1);
  EXPECT_EQ(framesUntilConfirmed(params, 40, 0.85), 2);
}

TEST(ObjectTracker, ConfirmsAtTheSecondFrameAndForgets) {
  const StereoRig rig = testRig();
  ObjectTracker tracker{TrackingParams(), 40};
  const Observation seen = at(rig, {0, 0, 20});
  const auto step = [&](int k, bool visible) {
    tracker.predict(0.1 * k, rig, Eigen::Isometry3d::Identity());
    tracker.update(visible ? std::vector<Observation>{seen} : std::vector<Observation>{});
  };
  step(0, true);
  EXPECT_FALSE(tracker.tracks().at(0).confirmed);
  step(1, false);
  step(2, true);
  EXPECT_TRUE(tracker.tracks().at(0).confirmed);
  step(3, false);
  step(4, false);
  EXPECT_EQ(tracker.tracks().size(), 1u);
  EXPECT_EQ(tracker.tracks()[0].observation, -1);
  step(5, false);
  EXPECT_TRUE(tracker.tracks().empty());
  // Never detected twice, so never confirmed.
  step(6, true);
  step(7, false);
  step(8, false);
  step(9, false);
  EXPECT_TRUE(tracker.tracks().empty());
}

TEST(ObjectTracker, KeepsWhatCannotBeSoughtForASecond) {
  const StereoRig rig = testRig();
  const Observation seen = at(rig, {0, 0, 20});
  for (const int wait : {9, 11}) {
    ObjectTracker tracker{TrackingParams(), 40};
    int k = 0;
    const auto step = [&](bool sought, bool found) {
      tracker.predict(0.1 * k++, rig,
                      sought ? std::optional(Eigen::Isometry3d::Identity()) : std::nullopt);
      tracker.update(found ? std::vector<Observation>{seen} : std::vector<Observation>{}, sought);
    };
    step(true, true);
    step(true, true);
    for (int i = 0; i < wait; ++i) step(false, false);
    ASSERT_EQ(tracker.tracks().size(), wait == 9 ? 1u : 0u);
    if (wait > 9) continue;
    for (int i = 0; i < 2; ++i) step(true, false);
    EXPECT_EQ(tracker.tracks().size(), 1u) << "missed twice";
    step(true, false);
    EXPECT_TRUE(tracker.tracks().empty()) << "missed three times";
  }
}

TEST(ObjectTracker, KeepsObjectsThatPassApart) {
  const StereoRig rig = testRig();
  ObjectTracker tracker{TrackingParams(), 40};
  int near_id = 0, far_id = 0;
  for (int k = 0; k < 12; ++k) {
    const double t = 0.1 * k;
    tracker.predict(t, rig, Eigen::Isometry3d::Identity());
    std::vector<Observation> seen{at(rig, {-3 + 5 * t, 0, 12}), at(rig, {3 - 5 * t, 0, 24})};
    if (k % 2) std::swap(seen[0], seen[1]);
    tracker.update(seen);
    ASSERT_EQ(tracker.tracks().size(), 2u);
    for (const ObjectTrack& track : tracker.tracks()) {
      int& id = track.last.distance_m < 18 ? near_id : far_id;
      if (k == 0) id = track.id;
      EXPECT_EQ(track.id, id) << k;
    }
  }
}

constexpr float kCar_px = 25, kBehind_px = 5;  // 10 m, 50 m

struct Scene {
  DetectionInput input;
  StereoRig& rig = input.rig;
  DisparityRange range;
  cv::Mat1f& disparity_px = input.measured_disparity_px;
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
  bool isThere() { return isStillThere(input, range, car, 0.6, mask); }
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

// A person before a small camera: the margin of 0.6 m reaches behind the camera.
TEST(UnseenObject, MayBeNearerThanTheMargin) {
  Scene scene;
  scene.rig.baseline_m = 0.05;
  scene.car.distance_m = scene.rig.disparityTimesDepth() / 60;  // 0.42 m
  EXPECT_FALSE(scene.isThere());
  scene.disparity_px(scene.car.box_px) = 60;
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
