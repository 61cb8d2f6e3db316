/// Uses exact disparities of a level road, 1.5 m below the camera.
#include "detection/plausible_object.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace predictive_stereo {
namespace {

constexpr double kCameraHeight_m = 1.5, kDepth_m = 15;
const MotionDetectionParams kParams;

class PlausibleObject : public testing::Test {
 protected:
  PlausibleObject() {
    rig.size = {600, 400};
    rig.fx_px = rig.fy_px = 600;
    rig.cx_left_px = rig.cx_right_px = 300;
    rig.cy_px = 200;
    rig.baseline_m = 0.5;
    road = RoadLine{rig.cy_px, rig.baseline_m / kCameraHeight_m};
    layer_px = static_cast<float>(rig.disparityTimesDepth() / kDepth_m);
    disparity.create(rig.size);
    for (int y = 0; y < disparity.rows; ++y)
      disparity.row(y).setTo(std::max(0.5, (y - rig.cy_px) * road->disparity_per_row));
  }

  int rowAt(double height_m) const {
    return cvRound(rig.cy_px + (kCameraHeight_m - height_m) * rig.fy_px / kDepth_m);
  }
  /// Box of an object of this width between two heights above the road.
  cv::Rect box(double width_m, double low_m, double high_m) const {
    return {cv::Point(200, rowAt(high_m)),
            cv::Point(200 + cvRound(width_m * rig.fx_px / kDepth_m), rowAt(low_m))};
  }
  bool plausible(const cv::Rect& box_px, LowerEnd lower_end) const {
    return isPlausible(rig, kParams, road, box_px, kDepth_m, layer_px, lower_end);
  }

  StereoRig rig;
  DisparityRange range;
  std::optional<RoadLine> road;
  float layer_px;
  cv::Mat1f disparity;
};

TEST_F(PlausibleObject, HasTheSizeOfARoadUser) {
  EXPECT_TRUE(plausible(box(1.8, 0, 1.5), LowerEnd::kFoot));
  EXPECT_FALSE(plausible(box(1.8, 0, 0.9 * kParams.min_height_m), LowerEnd::kFoot));
  EXPECT_FALSE(plausible(box(1.8, 0, 1.1 * kParams.max_height_m), LowerEnd::kFoot));
  EXPECT_FALSE(plausible(box(0.9 * kParams.min_width_m, 0, 1.5), LowerEnd::kFoot));
  EXPECT_FALSE(plausible(box(1.1 * kParams.max_width_m, 0, 1.5), LowerEnd::kFoot));
}

TEST_F(PlausibleObject, MayBeLowerWhereItIsNotSeenWhole) {
  const cv::Rect half = box(1.8, 0.8, 0.8 + 0.6 * kParams.min_height_m);
  EXPECT_FALSE(plausible(half, LowerEnd::kFoot));
  EXPECT_TRUE(plausible(half, LowerEnd::kHidden));
  const cv::Rect quarter = box(1.8, 0.8, 0.8 + 0.3 * kParams.min_height_m);
  EXPECT_FALSE(plausible(quarter, LowerEnd::kHidden));
  EXPECT_TRUE(plausible(quarter, LowerEnd::kCut));
}

// The tolerance is 1.2 m plus 3 % of the distance, 1.65 m here.
TEST_F(PlausibleObject, StandsOnTheRoad) {
  EXPECT_TRUE(plausible(box(1.8, 1.5, 3), LowerEnd::kFoot));
  EXPECT_FALSE(plausible(box(1.8, 1.8, 3.3), LowerEnd::kFoot));
  EXPECT_TRUE(plausible(box(1.8, 1.8, 3.3), LowerEnd::kCut));
  road.reset();
  EXPECT_TRUE(plausible(box(1.8, 1.8, 3.3), LowerEnd::kFoot));
}

// At most the upper half of a lorry is visible; a branch above a hedge is not an object.
TEST_F(PlausibleObject, HidesHalfOfItsHeightAtMost) {
  const double highest_m = 1.65 + 0.5 * kParams.max_height_m;
  EXPECT_TRUE(plausible(box(1.8, highest_m - 0.2, highest_m + 1), LowerEnd::kHidden));
  EXPECT_FALSE(plausible(box(1.8, highest_m + 0.2, highest_m + 1.4), LowerEnd::kHidden));
}

TEST_F(PlausibleObject, TellsAFootFromWhatIsHidden) {
  const cv::Rect car = box(1.8, 0, 1.5), behind = box(1.8, 0.7, 1.5);
  disparity(car).setTo(layer_px);
  const auto lowerEnd = [&](const cv::Rect& box_px) {
    LevelGround ground;
    ground.setFrame(rig, range, disparity);
    return lowerEndOf(rig, range, disparity, ground, box_px, layer_px, 1.1f * layer_px);
  };
  EXPECT_EQ(lowerEnd(car), LowerEnd::kFoot) << "the road before it is nearer, too";
  EXPECT_EQ(lowerEnd({car.x, 300, car.width, 98}), LowerEnd::kCut);
  // A hedge, two metres before it.
  const float hedge_px = static_cast<float>(rig.disparityTimesDepth() / (kDepth_m - 2));
  const cv::Rect hedge(behind.x, behind.br().y, behind.width, rowAt(-0.3) - behind.br().y);
  disparity(hedge).setTo(hedge_px);
  EXPECT_EQ(lowerEnd(behind), LowerEnd::kHidden);
  // A post occludes too little.
  disparity(hedge).setTo(layer_px);
  disparity(cv::Rect(hedge.x, hedge.y, hedge.width / 4, hedge.height)).setTo(hedge_px);
  EXPECT_EQ(lowerEnd(behind), LowerEnd::kFoot);
}

}  // namespace
}  // namespace predictive_stereo
