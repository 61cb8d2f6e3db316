/// Uses exact disparities: of upright boards and of a level ground, 1.5 m below the camera.
#include "detection/observation.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "detection/constants.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {
namespace {

StereoRig testRig() {
  StereoRig rig;
  rig.size = {400, 300};
  rig.fx_px = rig.fy_px = 500;
  rig.cx_left_px = rig.cx_right_px = 200;
  rig.cy_px = 150;
  rig.baseline_m = 0.5;
  return rig;
}

// An object whose pixels are in this part of the image.
Observation objectIn(const cv::Rect& area) {
  Observation object;
  object.mask = cv::Mat1b(area.size(), 255);
  object.box_px = area;
  return object;
}

TEST(ObjectShape, OfAnUprightRectangle) {
  DetectionInput input;
  input.rig = testRig();
  const cv::Rect area(250, 100, 51, 81);
  cv::Mat1f& disparity = input.measured_disparity_px;
  disparity = cv::Mat1f(input.rig.size, 5.0f);  // 50 m
  disparity(area) = 25.0f;                      // 10 m
  disparity(cv::Rect(250, 100, 51, 2)) = -1.0f;
  Observation object = objectIn(area);
  ASSERT_TRUE(measureShape(input, DisparityRange(), object));
  const Observation& seen = object;
  EXPECT_NEAR(seen.distance_m, 10, 1e-6);
  EXPECT_NEAR(seen.centre_m.x(), 75.0 / 50, 0.03);
  EXPECT_NEAR(seen.centre_m.y(), -10.0 / 50, 0.05);
  EXPECT_NEAR(seen.centre_m.z(), 10, 1e-6);
  EXPECT_NEAR(seen.size_m.x(), 0.9, 0.06);
  EXPECT_NEAR(seen.size_m.y(), 0.9 * 78 / 50, 0.08);
  EXPECT_NEAR(seen.size_m.z(), 0, 1e-6);
}

TEST(ObjectShape, IgnoresWhatIsNotInTheMaskAndTails) {
  DetectionInput input;
  input.rig = testRig();
  cv::Mat1f& disparity = input.measured_disparity_px;
  disparity = cv::Mat1f(input.rig.size, 20.0f);
  disparity(cv::Rect(120, 100, 20, 40)) = 60.0f;
  disparity(cv::Rect(100, 100, 20, 1)) = 90.0f;
  Observation object = objectIn({100, 100, 40, 40});
  object.mask.colRange(20, 40).setTo(0);
  ASSERT_TRUE(measureShape(input, DisparityRange(), object));
  EXPECT_NEAR(object.distance_m, 12.5, 1e-6);
}

TEST(ObjectShape, NeedsPoints) {
  DetectionInput input;
  input.rig = testRig();
  input.measured_disparity_px = cv::Mat1f(input.rig.size, -1.0f);
  Observation object = objectIn({100, 100, 40, 40});
  EXPECT_FALSE(measureShape(input, DisparityRange(), object));
}

constexpr double kCameraHeight_m = 1.5, kDepth_m = 15;
const MotionDetectionParams kParams;

Extent extent(double width_m, double foot_m, double top_m) {
  return {width_m, top_m - foot_m, Extent::Heights{foot_m, top_m}};
}

bool plausible(const Extent& seen, LowerEnd lower_end) {
  return isPlausible(kParams, seen, lower_end);
}

TEST(PlausibleObject, HasTheSizeOfARoadUser) {
  EXPECT_TRUE(plausible(extent(1.8, 0, 1.5), LowerEnd::kFoot));
  EXPECT_FALSE(plausible(extent(1.8, 0, 0.9 * kParams.min_height_m), LowerEnd::kFoot));
  EXPECT_FALSE(plausible(extent(0.9 * kParams.min_width_m, 0, 1.5), LowerEnd::kFoot));
  EXPECT_FALSE(plausible(extent(1.1 * kParams.max_width_m, 0, 1.5), LowerEnd::kFoot));
}

TEST(PlausibleObject, MayBeLowerWhereItIsNotSeenWhole) {
  const Extent half = extent(1.8, 0.8, 0.8 + 0.6 * kParams.min_height_m);
  EXPECT_FALSE(plausible(half, LowerEnd::kFoot));
  EXPECT_TRUE(plausible(half, LowerEnd::kHidden));
  const Extent quarter = extent(1.8, 0.8, 0.8 + 0.3 * kParams.min_height_m);
  EXPECT_FALSE(plausible(quarter, LowerEnd::kHidden));
  EXPECT_TRUE(plausible(quarter, LowerEnd::kCut));
}

TEST(PlausibleObject, StandsOnTheGround) {
  EXPECT_TRUE(plausible(extent(1.8, kParams.max_foot_m - 0.1, 3), LowerEnd::kFoot));
  const Extent above = extent(1.8, kParams.max_foot_m + 0.1, 3);
  EXPECT_FALSE(plausible(above, LowerEnd::kFoot));
  EXPECT_TRUE(plausible(above, LowerEnd::kHidden));
  EXPECT_TRUE(plausible(above, LowerEnd::kCut));
}

// A branch above a hedge is not an object.
TEST(PlausibleObject, IsNotHigherThanALorry) {
  for (const LowerEnd lower_end : {LowerEnd::kFoot, LowerEnd::kHidden}) {
    EXPECT_TRUE(plausible(extent(1.8, 1, kParams.max_height_m - 0.1), lower_end));
    EXPECT_FALSE(plausible(extent(1.8, 1, kParams.max_height_m + 0.1), lower_end));
    EXPECT_FALSE(plausible(extent(1.8, -0.1, kParams.max_height_m + 0.1), lower_end));
  }
}

TEST(PlausibleObject, HasItsOwnHeightWhereNoGroundIsInView) {
  for (const double height_m : {0.9 * kParams.min_height_m, kParams.max_height_m + 0.5})
    EXPECT_FALSE(plausible({1.8, height_m, {}}, LowerEnd::kFoot)) << height_m;
  EXPECT_TRUE(plausible({1.8, 1.5, {}}, LowerEnd::kFoot));
}

class ItsLowerEnd : public testing::Test {
 protected:
  ItsLowerEnd() {
    rig.size = {600, 400};
    rig.fx_px = rig.fy_px = 600;
    rig.cx_left_px = rig.cx_right_px = 300;
    rig.cy_px = 200;
    rig.baseline_m = 0.5;
    layer_px = static_cast<float>(rig.disparityTimesDepth() / kDepth_m);
    plane.b = rig.baseline_m / kCameraHeight_m;
    plane.c = -plane.b * rig.cy_px;
    plane.camera_height_m = kCameraHeight_m;
    disparity.create(rig.size);
    for (int y = 0; y < disparity.rows; ++y)
      disparity.row(y).setTo(std::max(0.5, plane.disparityAt(0, y)));
  }
  int rowAt(double height_m) const {
    return cvRound(rig.cy_px + (kCameraHeight_m - height_m) * rig.fy_px / kDepth_m);
  }
  LowerEnd of(const cv::Rect& box_px, const std::optional<GroundPlane>& ground) const {
    DepthCells cells;
    cells.setFrame(DisparityRange(), disparity, cv::Mat1f(disparity.size(), 1));
    return lowerEndOf(cells, ground, box_px, 1.1f * layer_px);
  }

  StereoRig rig;
  float layer_px;
  GroundPlane plane;
  cv::Mat1f disparity;
};

TEST_F(ItsLowerEnd, IsAFootOrHidden) {
  const cv::Rect car(cv::Point(200, rowAt(1.5)), cv::Point(272, rowAt(0)));
  const cv::Rect behind(cv::Point(200, rowAt(1.5)), cv::Point(272, rowAt(0.7)));
  disparity(car).setTo(layer_px);
  EXPECT_EQ(of(car, plane), LowerEnd::kFoot) << "the ground before it is nearer, too";
  EXPECT_EQ(of({car.x, 300, car.width, 98}, plane), LowerEnd::kCut);
  // A hedge, two metres before it.
  const float hedge_px = static_cast<float>(rig.disparityTimesDepth() / (kDepth_m - 2));
  const cv::Rect hedge(behind.x, behind.br().y, behind.width, rowAt(-0.3) - behind.br().y);
  disparity(hedge).setTo(hedge_px);
  EXPECT_EQ(of(behind, plane), LowerEnd::kHidden);
  EXPECT_EQ(of(behind, {}), LowerEnd::kFoot) << "it may be the ground";
  // A post occludes too little.
  disparity(hedge).setTo(layer_px);
  disparity(cv::Rect(hedge.x, hedge.y, hedge.width / 4, hedge.height)).setTo(hedge_px);
  EXPECT_EQ(of(behind, plane), LowerEnd::kFoot);
}

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

Observation atRest(const cv::Rect& box, double distance_m) {
  return moving(at(box, distance_m), {0, 0, 0});
}

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
  const Observation car = atRest(kCar, 10);
  const int gap_px = static_cast<int>(kGap_m / 2.0 * kCar.width);
  const auto beside = [&](int pixels) {
    return atRest({kCar.br().x + pixels, kCar.y, 20, 20}, 10);
  };
  EXPECT_TRUE(belongsTo(kParams, beside(0), car));
  EXPECT_TRUE(belongsTo(kParams, beside(gap_px - 1), car));
  EXPECT_FALSE(belongsTo(kParams, beside(gap_px), car));
  const auto above = [&](int pixels) { return atRest({kCar.x, kCar.y - 20 - pixels, 20, 20}, 10); };
  EXPECT_TRUE(belongsTo(kParams, above(gap_px - 1), car));
  EXPECT_FALSE(belongsTo(kParams, above(gap_px), car));
}

TEST(BelongsTo, AQuarterOfTheSizeAtMost) {
  const Observation car = atRest(kCar, 10);
  EXPECT_TRUE(belongsTo(kParams, atRest({kCar.br().x, kCar.y, 50, 40}, 9.99), car));
  // The metric size counts, not that in the image.
  EXPECT_FALSE(belongsTo(kParams, atRest({kCar.br().x, kCar.y, 50, 40}, 10.01), car));
}

TEST(BelongsTo, AtDepthsThatGoOn) {
  const Observation car = atRest(kCar, 10);  // to 10.5 m
  const cv::Rect beside(kCar.br().x, kCar.y, 20, 20);
  EXPECT_TRUE(belongsTo(kParams, atRest(beside, 14.99), car));
  EXPECT_FALSE(belongsTo(kParams, atRest(beside, 15.01), car));
  EXPECT_TRUE(belongsTo(kParams, atRest(beside, 5.01), car));  // to 5.51 m
  EXPECT_FALSE(belongsTo(kParams, atRest(beside, 4.99), car));
}

TEST(BelongsTo, OfAVelocityWithinThreeSigmas) {
  const cv::Rect beside(kCar.br().x, kCar.y, 20, 20);
  // Both variances and 1 m/s: 9 m/s.
  const Observation car = moving(at(kCar, 10), {0, 0, 5}, 40);
  const auto part = [&](const Eigen::Vector3d& v) { return moving(at(beside, 10), v, 40); };
  EXPECT_TRUE(belongsTo(kParams, part({0, 0, 5 + 26.9}), car));
  EXPECT_FALSE(belongsTo(kParams, part({0, 0, 5 + 27.1}), car));
  EXPECT_FALSE(belongsTo(kParams, part({20, 0, 5 + 20}), car));
}

// Two ends of a car, 10 m away, with a door of 40 columns between them.
struct MoveAsOne : testing::Test {
  MoveAsOne() {
    input.rig = testRig();
    ends_px = static_cast<float>(input.rig.disparityTimesDepth() / 10);
    input.measured_disparity_px = cv::Mat1f(input.rig.size, ends_px);
  }
  static Observation endOfCar(int x, double depth_m = 10, const Eigen::Vector3d& v = {5, 0, 0}) {
    Observation seen = moving(at({x, 100, 30, 40}, depth_m), v, 0);
    seen.centre_m = {0, 0, depth_m};
    return seen;
  }
  bool areOne(const Observation& one, const Observation& other) const {
    const bool result = moveAsOne(input, kParams, one, other);
    EXPECT_EQ(moveAsOne(input, kParams, other, one), result);
    return result;
  }

  DetectionInput input;
  float ends_px = 0;
  const Observation rear = endOfCar(100);
};

TEST_F(MoveAsOne, AtOneVelocity) {
  EXPECT_TRUE(areOne(rear, endOfCar(170)));
  EXPECT_TRUE(areOne(rear, endOfCar(170, 10, {5 + 2.9, 0, 0}))) << "3 sigma: 3 m/s";
  EXPECT_FALSE(areOne(rear, endOfCar(170, 10, {5 + 3.1, 0, 0})));
  EXPECT_FALSE(areOne(rear, endOfCar(170, 10, {5, 0, 3.1})));
}

TEST_F(MoveAsOne, AtOneDepth) {
  EXPECT_TRUE(areOne(rear, endOfCar(130, 10 + 0.59))) << "beside each other";
  EXPECT_FALSE(areOne(rear, endOfCar(130, 10 + 0.61)));
  // Far away 1 px is more than that.
  EXPECT_TRUE(areOne(endOfCar(100, 40), endOfCar(130, 46)));
  EXPECT_FALSE(areOne(endOfCar(100, 40), endOfCar(130, 48)));
}

TEST_F(MoveAsOne, WithASurfaceBetweenThem) {
  const Observation front = endOfCar(170);
  const cv::Rect door(130, 100, 40, 40);
  // The background is seen between two people who walk side by side.
  input.measured_disparity_px(door).setTo(ends_px / 2);
  EXPECT_FALSE(areOne(rear, front));
  input.measured_disparity_px(cv::Rect(130, 100, 21, 40)).setTo(ends_px + 1.5f);
  EXPECT_TRUE(areOne(rear, front)) << "most of it is enough";
  input.measured_disparity_px(door).setTo(DisparityRange().invalid());
  EXPECT_FALSE(areOne(rear, front));
}

// Two people who walk along a wall are not one.
TEST_F(MoveAsOne, IfHalfOfTheWholeIsTheirs) {
  EXPECT_TRUE(areOne(rear, endOfCar(190)));
  EXPECT_FALSE(areOne(rear, endOfCar(191)));
}

TEST_F(MoveAsOne, SideBySideOrOneAboveTheOther) {
  // Small enough that both boxes cover most of the box around them.
  const auto areOneWith = [&](const cv::Rect& box) {
    Observation small = endOfCar(100);
    small.box_px = box;
    return areOne(rear, small);
  };
  EXPECT_TRUE(areOneWith({110, 92, 4, 4})) << "above";
  EXPECT_TRUE(areOneWith({130, 96, 4, 4})) << "they touch";
  EXPECT_FALSE(areOneWith({131, 94, 4, 4})) << "diagonal";
  EXPECT_FALSE(areOneWith({131, 96, 4, 4})) << "diagonal, and no row is between them";
  EXPECT_FALSE(areOneWith({130, 94, 4, 4})) << "diagonal, and no column is between them";
}

}  // namespace
}  // namespace predictive_stereo
