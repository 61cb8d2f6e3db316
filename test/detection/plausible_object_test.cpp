/// Uses exact disparities of a level ground, 1.5 m below the camera.
#include "detection/plausible_object.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {
namespace {

constexpr double kCameraHeight_m = 1.5, kDepth_m = 15;
const MotionDetectionParams kParams;

Extent extent(double width_m, double foot_m, double top_m) {
  return {width_m, top_m - foot_m, Extent::Heights{foot_m, top_m}};
}

bool plausible(const Extent& seen, LowerEnd lower_end) {
  return isPlausible(kParams, seen, lower_end, kDepth_m);
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

// The ground may rise by 3 % of the distance, 0.45 m here.
TEST(PlausibleObject, StandsOnTheGround) {
  EXPECT_TRUE(plausible(extent(1.8, kParams.max_foot_m + 0.4, 3), LowerEnd::kFoot));
  const Extent above = extent(1.8, kParams.max_foot_m + 0.5, 3);
  EXPECT_FALSE(plausible(above, LowerEnd::kFoot));
  EXPECT_TRUE(plausible(above, LowerEnd::kHidden));
  EXPECT_TRUE(plausible(above, LowerEnd::kCut));
}

// A branch above a hedge is not an object.
TEST(PlausibleObject, IsNotHigherThanALorry) {
  for (const LowerEnd lower_end : {LowerEnd::kFoot, LowerEnd::kHidden}) {
    EXPECT_TRUE(plausible(extent(1.8, 1, kParams.max_height_m + 0.4), lower_end));
    EXPECT_FALSE(plausible(extent(1.8, 1, kParams.max_height_m + 0.5), lower_end));
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

}  // namespace
}  // namespace predictive_stereo
