#include "detection/steady_ground.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "cell_rig.h"

namespace predictive_stereo {
namespace {

// A plane below the camera, which rolls.
DepthCells groundAt(double height_m, double roll_deg = 0) {
  const StereoRig rig = cellRig();
  const double roll = roll_deg * M_PI / 180;
  DepthCells cells = unknownCells(0.01f);
  for (int v = 0; v < kCellRows; ++v)
    for (int u = 0; u < kCellColumns; ++u) {
      const double x_px = kCellSide_px * u + kCellCentre_px - rig.cx_left_px,
                   y_px = kCellSide_px * v + kCellCentre_px - rig.cy_px;
      const double below_px = std::cos(roll) * y_px + std::sin(roll) * x_px;
      cells.disparity_px(v, u) =
          static_cast<float>(std::max(0.0, rig.baseline_m * below_px / height_m));
    }
  return cells;
}

TEST(SteadyGround, IsThatOfTwoSuccessiveFrames) {
  SteadyGround ground;
  ground.setFrame(cellRig(), groundAt(1.5));
  EXPECT_FALSE(ground.plane());
  ground.setFrame(cellRig(), groundAt(1.5));
  ASSERT_TRUE(ground.plane());
  EXPECT_NEAR(ground.plane()->camera_height_m, 1.5, 0.01);
  ground.setFrame(cellRig(), groundAt(1.8));
  EXPECT_FALSE(ground.plane()) << "another height";
  ground.setFrame(cellRig(), groundAt(1.7));
  ASSERT_TRUE(ground.plane()) << "within 10 %";
  EXPECT_NEAR(ground.plane()->camera_height_m, 1.7, 0.01) << "of this frame";
  ground.setFrame(cellRig(), groundAt(1.7, 15));
  EXPECT_TRUE(ground.plane());
  ground.setFrame(cellRig(), groundAt(1.7, -10));
  EXPECT_FALSE(ground.plane()) << "another direction";
}

TEST(SteadyGround, EndsWhereNoneIsInView) {
  SteadyGround ground;
  for (int k = 0; k < 2; ++k) ground.setFrame(cellRig(), groundAt(1.5));
  DepthCells wall = groundAt(1.5);
  wall.disparity_px = 20;
  ground.setFrame(cellRig(), wall);
  EXPECT_FALSE(ground.plane());
  ground.setFrame(cellRig(), groundAt(1.5));
  EXPECT_FALSE(ground.plane());
  ground.setFrame(cellRig(), groundAt(1.5));
  EXPECT_TRUE(ground.plane());
  ground.reset();
  EXPECT_FALSE(ground.plane());
  ground.setFrame(cellRig(), groundAt(1.5));
  EXPECT_FALSE(ground.plane());
}

}  // namespace
}  // namespace predictive_stereo
