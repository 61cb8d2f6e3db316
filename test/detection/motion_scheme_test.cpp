/// A board on a level ground before a wall, with exact disparities.
#include "detection/motion_scheme.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "detection/board_scene.h"

namespace predictive_stereo {
namespace {

// Free space shows whole obstacles, but neither their lowest 0.25 m nor their velocity. Motion
// shows these, where there is texture.
TEST(MotionScheme, WhatFreeSpaceAndMotionFindHasThePixelsOfBoth) {
  constexpr double kStep_m = 0.2, kCameraHeight_m = 1.5, kDepth_m = 5;
  MotionScheme scheme{DisparityRange(), MotionDetectionParams()};
  const ObjectTracker nothing_known{TrackingParams(), 40};
  for (int k = 0; k < 8; ++k) {
    SCOPED_TRACE(k);
    Board runner{-1.5 + kStep_m * k, kCameraHeight_m - 1.7, 0.6, 1.7, kDepth_m};
    runner.texture = Texture(1, 100, 250, 0.08);
    const BoardView view = viewOf({{wallAt(12), runner}, kCameraHeight_m}, 0.1 * k);
    const auto& objects = scheme.observe(view.input, 1, nothing_known);
    if (k < 4) continue;
    const auto found = std::find_if(objects.begin(), objects.end(), [](const Observation& o) {
      return std::abs(o.distance_m - kDepth_m) < 0.1;
    });
    ASSERT_NE(found, objects.end());
    const Observation& seen = *found;
    const double px_per_m = 300 / kDepth_m, left_px = 160 + runner.left_m * px_per_m;
    EXPECT_NEAR(seen.box_px.x, left_px, 6);
    EXPECT_NEAR(seen.box_px.br().x, left_px + 0.6 * px_per_m, 6);
    EXPECT_NEAR(seen.box_px.y, 120 + runner.top_m * px_per_m, 6);
    EXPECT_NEAR(seen.box_px.br().y, 120 + kCameraHeight_m * px_per_m, 6);
    EXPECT_EQ(found->mask.size(), seen.box_px.size());
    ASSERT_TRUE(seen.has_velocity);
    EXPECT_NEAR(seen.velocity_mps.x(), 10 * kStep_m, 0.3);
  }
}

}  // namespace
}  // namespace predictive_stereo
