/// Which observations belong to one object: cars and their parts, at exact distances and
/// velocities.
#include "detection/same_object.h"

#include <gtest/gtest.h>

#include <limits>

#include "detection/constants.h"

namespace predictive_stereo {
namespace {

constexpr double kAny = std::numeric_limits<double>::infinity();
constexpr double kFocal_px = 500;

// Half a metre deep.
Observation at(const cv::Rect& box, double distance_m) {
  Observation seen;
  seen.box_px = box;
  seen.distance_m = distance_m;
  seen.size_m = Eigen::Vector3d(box.width, box.height, 0) * distance_m / kFocal_px;
  seen.size_m.z() = 0.5;
  return seen;
}

Observation moving(Observation seen, const Eigen::Vector3d& velocity_mps, double variance = 0.1) {
  seen.has_velocity = true;
  seen.velocity_mps = velocity_mps;
  seen.velocity_covariance = variance * Eigen::Matrix3d::Identity();
  return seen;
}

const MotionDetectionParams kParams;
// 2 m wide, 1.6 m high, 10 m away.
const cv::Rect kCar(200, 100, 100, 80);

TEST(Overlaps, MoreThanHalfOfTheSmallerBox) {
  const Observation car = at(kCar, 10);
  for (int wide : {20, 100, 300}) {
    // Covers `common` columns at the car's left end, and extends to the left.
    const auto covering = [&](int common) {
      return at({kCar.x + common - wide, kCar.y, wide, kCar.height}, 10);
    };
    const int half = std::min(wide, kCar.width) / 2;
    EXPECT_FALSE(overlaps(kParams, covering(half), car)) << wide;
    EXPECT_TRUE(overlaps(kParams, covering(half + 1), car)) << wide;
    EXPECT_TRUE(overlaps(kParams, car, covering(half + 1))) << wide;
  }
}

TEST(Overlaps, AtAboutTheSameDistance) {
  const double depth_m = kParams.max_width_m / 2;
  EXPECT_TRUE(overlaps(kParams, at(kCar, 10 + depth_m - 0.01), at(kCar, 10)));
  EXPECT_FALSE(overlaps(kParams, at(kCar, 10 + depth_m + 0.01), at(kCar, 10)));
  EXPECT_FALSE(overlaps(kParams, at(kCar, 10), at(kCar, 10 + depth_m + 0.01)));
}

TEST(BelongsTo, WithinAGapOfTheBox) {
  const Observation car = at(kCar, 10);
  const int gap_px = static_cast<int>(DetectionConstants::kGap_m / 2.0 * kCar.width) + 8;
  const auto beside = [&](int pixels) { return at({kCar.br().x + pixels, kCar.y, 20, 20}, 10); };
  EXPECT_TRUE(belongsTo(beside(0), car, kAny));
  EXPECT_TRUE(belongsTo(beside(gap_px - 1), car, kAny));
  EXPECT_FALSE(belongsTo(beside(gap_px), car, kAny));
  const auto above = [&](int pixels) { return at({kCar.x, kCar.y - 20 - pixels, 20, 20}, 10); };
  EXPECT_TRUE(belongsTo(above(gap_px - 1), car, kAny));
  EXPECT_FALSE(belongsTo(above(gap_px), car, kAny));
}

TEST(BelongsTo, PartsAreSmaller) {
  const Observation car = at(kCar, 10);
  const Observation quarter = at({kCar.br().x, kCar.y, 50, 40}, 10);
  EXPECT_TRUE(belongsTo(quarter, car, 0.2501));
  EXPECT_FALSE(belongsTo(quarter, car, 0.2499));
  // The metric size counts, not that in the image.
  EXPECT_FALSE(belongsTo(at({kCar.br().x, kCar.y, 50, 40}, 12), car, 0.2501));
}

TEST(BelongsTo, AtDepthsThatGoOn) {
  const Observation car = at(kCar, 10);  // to 10.5 m
  const cv::Rect beside(kCar.br().x, kCar.y, 20, 20);
  EXPECT_TRUE(belongsTo(at(beside, 14.99), car, kAny));
  EXPECT_FALSE(belongsTo(at(beside, 15.01), car, kAny));
  EXPECT_TRUE(belongsTo(at(beside, 5.01), car, kAny));  // to 5.51 m
  EXPECT_FALSE(belongsTo(at(beside, 4.99), car, kAny));
}

TEST(BelongsTo, WhatTheObjectHides) {
  const Observation car = at(kCar, 10);
  const auto hidden = [&](int columns, double distance_m) {
    return moving(at({kCar.br().x - columns, kCar.y, 100, 80}, distance_m), {9, 0, 0});
  };
  EXPECT_TRUE(belongsTo(hidden(31, 40), moving(car, {0, 0, 0}), kAny))
      << "however deep, however fast";
  EXPECT_FALSE(belongsTo(hidden(30, 40), moving(car, {0, 0, 0}), kAny));
  EXPECT_FALSE(belongsTo(hidden(31, 4), moving(car, {0, 0, 0}), kAny))
      << "what is nearer is not hidden";
}

TEST(BelongsTo, OfAVelocityWithinThreeSigmas) {
  const cv::Rect beside(kCar.br().x, kCar.y, 20, 20);
  // Both variances plus 2 m/s for a side that slides along itself: 9 m/s.
  const Observation car = moving(at(kCar, 10), {0, 0, 5}, 38.5);
  const auto part = [&](const Eigen::Vector3d& v) { return moving(at(beside, 10), v, 38.5); };
  EXPECT_TRUE(belongsTo(part({0, 0, 5 + 26.9}), car, kAny));
  EXPECT_FALSE(belongsTo(part({0, 0, 5 + 27.1}), car, kAny));
  EXPECT_FALSE(belongsTo(part({20, 0, 5 + 20}), car, kAny));
  EXPECT_TRUE(belongsTo(at(beside, 10), car, kAny)) << "of one nothing is known";
  EXPECT_TRUE(belongsTo(part({0, 0, 99}), at(kCar, 10), kAny));
}

}  // namespace
}  // namespace predictive_stereo
