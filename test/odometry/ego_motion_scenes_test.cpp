/// Ego-motion on the synthetic street and on KITTI compared with true poses.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cstdlib>

#include "evaluation/odometry_evaluation.h"
#include "evaluation/simulation/street.h"
#include "odometry/path_windows.h"
#include "predictive_stereo/ego_motion.h"

namespace predictive_stereo {
namespace {

struct Driven {
  double estimated_m = 0, true_m = 0, end_error_m = 0;
  double largest_error_m = 0, largest_error_rad = 0;
  double mean_normalized_error = 0;
  int lost = 0;

  double driftPercent() const { return 100 * end_error_m / true_m; }
};

EgoMotionParams perfectlyCalibrated() {
  EgoMotionParams params;
  params.principal_point_sigma_px = params.scale_sigma = params.disparity_tilt_sigma_px = 0;
  return params;
}

// Runs a part of a scene; `spoil` may change the images of a frame.
template <class Spoil>
Driven drive(const StreetParams& params, int first, int frames, const Spoil& spoil) {
  const Street street(params);
  EgoMotion ego_motion{perfectlyCalibrated()};
  Driven driven;
  Eigen::Isometry3d T_start_cam = Eigen::Isometry3d::Identity();
  int reference = first;
  double last_s = 0;
  for (int k = first; k < first + frames; ++k) {
    StreetFrame frame = street.render(k);
    spoil(k - first, frame.left, frame.right);
    const EgoMotionEstimate estimate =
        ego_motion.estimate(frame.left, frame.right, street.rig(), {}, {}, frame.stamp_s - last_s);
    last_s = frame.stamp_s;
    if (k == first) continue;
    T_start_cam = T_start_cam * estimate.motion.T_cam_prev.inverse();
    if (estimate.state != PoseState::kKnown) {
      ++driven.lost;
      EXPECT_TRUE(estimate.motion.T_cam_prev.matrix().isIdentity());
      EXPECT_EQ(estimate.motion.covariance(0, 0), 9999);
      continue;
    }
    EXPECT_EQ(estimate.frames, k - reference);
    const Eigen::Isometry3d T_true = street.poseOf(k).inverse() * street.poseOf(reference);
    const Eigen::Isometry3d delta = estimate.motion.T_cam_prev * T_true.inverse();
    const Eigen::AngleAxisd rotation(delta.linear());
    Vector6d error;
    error << delta.translation(), rotation.angle() * rotation.axis();
    driven.largest_error_m = std::max(driven.largest_error_m, error.head<3>().norm());
    driven.largest_error_rad = std::max(driven.largest_error_rad, error.tail<3>().norm());
    driven.mean_normalized_error +=
        error.dot(estimate.motion.covariance.inverse() * error) / 6 / (frames - 1);
    driven.true_m += T_true.translation().norm();
    driven.estimated_m += estimate.motion.T_cam_prev.translation().norm();
    reference = k;
  }
  const Eigen::Isometry3d T_true = street.poseOf(first).inverse() * street.poseOf(reference);
  driven.end_error_m = (T_start_cam.translation() - T_true.translation()).norm();
  return driven;
}

StreetParams sceneParams(const std::string& scene) {
  StreetParams params;
  params.scene = scene;
  params.seed = 3;
  return params;
}

Driven drive(const StreetParams& params, int first, int frames) {
  return drive(params, first, frames, [](int, cv::Mat1b&, cv::Mat1b&) {});
}
Driven drive(const std::string& scene, int first, int frames) {
  return drive(sceneParams(scene), first, frames);
}

constexpr double kDegree = 3.14159265358979 / 180;

TEST(EgoMotionScenes, Street) {
  const Driven driven = drive("street", 20, 12);
  EXPECT_EQ(driven.lost, 0);
  EXPECT_LT(driven.driftPercent(), 0.5);
  EXPECT_GT(driven.mean_normalized_error, 0.5);
  EXPECT_LT(driven.mean_normalized_error, 2);
}

TEST(EgoMotionScenes, VehiclesThatMoveAlongCoverFortyPercentOfTheView) {
  const Driven driven = drive("crowded", 20, 10);
  EXPECT_EQ(driven.lost, 0);
  EXPECT_LT(driven.driftPercent(), 1);
}

// The first pair has no history from which the static scene is known.
TEST(EgoMotionScenes, StartsAmongVehiclesThatMoveAlong) {
  for (const char* scene : {"crowded", "near_half_moves"})
    for (const cv::Size size : {cv::Size(1242, 375), cv::Size(932, 281)}) {
      StreetParams params = sceneParams(scene);
      params.width = size.width;
      params.height = size.height;
      int hijacked = 0;
      for (int first = 0; first < 50; first += 5)
        hijacked += drive(params, first, 2).largest_error_m > 0.1 ? 1 : 0;
      EXPECT_EQ(hijacked, 0) << scene << " " << size;
    }
}

TEST(EgoMotionScenes, HalfOfTheViewMoves) {
  const Driven driven = drive("near_half_moves", 20, 10);
  EXPECT_EQ(driven.lost, 0);
  EXPECT_LT(driven.driftPercent(), 1);
}

// Half the resolution leaves fewer static points than there are on the vehicles that move along:
// they would need a camera that stops within a tenth of a second.
TEST(EgoMotionScenes, TheCameraDoesNotStopWithinAFrame) {
  for (const char* scene : {"crowded", "near_half_moves"}) {
    StreetParams params = sceneParams(scene);
    params.seed = 1;
    params.width = 621;
    params.height = 188;
    const Driven driven = drive(params, 0, 40);
    EXPECT_EQ(driven.lost, 0) << scene;
    EXPECT_LT(driven.largest_error_m, 0.1) << scene;
  }
}

// Near people before the small camera of a slow robot.
TEST(EgoMotionScenes, PeopleBeforeASmallCamera) {
  for (int seed : {1, 2}) {
    StreetParams params = sceneParams("people_slow");
    params.seed = seed;
    params.width = 320;
    params.height = 240;
    const Driven driven = drive(params, seed == 1 ? 0 : 100, 25);
    EXPECT_EQ(driven.lost, 0) << seed;
    EXPECT_LT(driven.largest_error_m, 0.04) << seed;
    EXPECT_LT(driven.mean_normalized_error, 10) << seed;
  }
}

// 2.8 m per frame from the first frame on, behind vehicles with the same speed.
TEST(EgoMotionScenes, Highway) {
  const Driven driven = drive("highway", 20, 15);
  EXPECT_EQ(driven.lost, 0);
  EXPECT_GT(driven.true_m, 2.7 * 14);
  EXPECT_LT(driven.driftPercent(), 0.5);
}

TEST(EgoMotionScenes, NoDriftAtStandstill) {
  const Driven driven = drive("standstill", 20, 8);
  EXPECT_EQ(driven.lost, 0);
  EXPECT_LT(driven.largest_error_m, 0.001);
  EXPECT_LT(driven.largest_error_rad, 0.005 * kDegree);
  EXPECT_LT(driven.end_error_m, 0.001);
}

TEST(EgoMotionScenes, FastRotation) {
  const Driven driven = drive("fast_rotation", 10, 8);
  EXPECT_EQ(driven.lost, 0);
  EXPECT_LT(driven.driftPercent(), 0.5);
  EXPECT_LT(driven.largest_error_rad, 0.02 * kDegree);
}

TEST(EgoMotionScenes, DroppedAndDuplicatedFrames) {
  for (const char* scene : {"dropped", "duplicated"}) {
    const Driven driven = drive(scene, 20, 8);
    EXPECT_EQ(driven.lost, 0) << scene;
    EXPECT_LT(driven.driftPercent(), 0.5) << scene;
  }
}

TEST(EgoMotionScenes, BadLight) {
  for (const char* scene : {"night", "saturated", "low_texture", "blur"}) {
    const Driven driven = drive(scene, 20, 6);
    EXPECT_EQ(driven.lost, 0) << scene;
    EXPECT_LT(driven.driftPercent(), 1) << scene;
  }
}

TEST(EgoMotionScenes, RecoversOnTheNextGoodFrame) {
  const Driven driven =
      drive(sceneParams("static"), 20, 9, [](int k, cv::Mat1b& left, cv::Mat1b& right) {
        if (k != 4 && k != 5) return;
        left.setTo(k == 4 ? 255 : 0);
        right.setTo(k == 4 ? 255 : 0);
      });
  EXPECT_EQ(driven.lost, 2);
  EXPECT_LT(driven.driftPercent(), 0.5);
}

TEST(EgoMotionScenes, KittiDrive0020) {
  const char* kitti = std::getenv("KITTI_EXCERPTS");
  if (!kitti) GTEST_SKIP() << "KITTI_EXCERPTS is not set";
  const auto sequence =
      kittiDriveSequence(std::string(kitti) + "/2011_09_30", "2011_09_30_drive_0020_sync");
  const OdometryEvaluation result = evaluateOdometry(*sequence, EgoMotionParams());
  EXPECT_EQ(result.lost, 0);
  EXPECT_LE(result.mean.translation_m, 0.013);
  EXPECT_LE(result.mean.rotation_rad, 0.054 * kDegree);
  EXPECT_LT(std::abs(result.length_error_percent), 0.5);
  for (const PathWindows& window : pathWindows(result)) {
    if (window.motions < 10) continue;
    EXPECT_GT(window.median_without_jitter, 0.4) << window.motions << " motions";
    EXPECT_LT(window.median_without_jitter, 2.5) << window.motions << " motions";
  }
}

// Common errors of successive motions are treated as such.
TEST(EgoMotionScenes, CovarianceOfAPath) {
  StreetParams params;
  params.scene = "static";
  params.seed = 3;
  params.frames = 26;
  const auto sequence = streetSequence(params);
  const OdometryEvaluation result = evaluateOdometry(*sequence, perfectlyCalibrated());
  for (const PathWindows& window : pathWindows(result)) {
    EXPECT_GT(window.mean_normalized, 0.4) << window.motions << " motions";
    EXPECT_LT(window.mean_normalized, 2.5) << window.motions << " motions";
  }
}

// Only every second or third frame: steps of 2.4 and 3.6 m, as at 86 and 130 km/h.
TEST(EgoMotionScenes, KittiDrive0020InLargeSteps) {
  const char* kitti = std::getenv("KITTI_EXCERPTS");
  if (!kitti) GTEST_SKIP() << "KITTI_EXCERPTS is not set";
  const auto sequence =
      kittiDriveSequence(std::string(kitti) + "/2011_09_30", "2011_09_30_drive_0020_sync");
  const auto poses = sequence->poses();
  ASSERT_TRUE(poses);
  for (const int step : {2, 3}) {
    EgoMotion ego_motion{EgoMotionParams()};
    double error_m = 0, length_m = 0, estimated_m = 0;
    for (int k = 0; k < sequence->frames(); k += step) {
      const SequenceFrame frame = sequence->frame(k);
      const EgoMotionEstimate estimate =
          ego_motion.estimate(frame.left, frame.right, sequence->rig());
      if (k == 0) continue;
      EXPECT_EQ(estimate.state, PoseState::kKnown) << k << " in steps of " << step;
      const auto i = static_cast<size_t>(k);
      const Eigen::Isometry3d T_true =
          (*poses)[i].inverse() * (*poses)[i - static_cast<size_t>(step)];
      error_m += (estimate.motion.T_cam_prev * T_true.inverse()).translation().norm();
      length_m += T_true.translation().norm();
      estimated_m += estimate.motion.T_cam_prev.translation().norm();
    }
    EXPECT_LT(error_m / length_m, 0.013) << "steps of " << step;
    EXPECT_LT(std::abs(estimated_m / length_m - 1), 0.005) << "steps of " << step;
  }
}

TEST(EgoMotionScenes, KittiDrivesAreAsLongAsTheyAre) {
  const char* kitti = std::getenv("KITTI_EXCERPTS");
  if (!kitti) GTEST_SKIP() << "KITTI_EXCERPTS is not set";
  for (const char* drive : {"2011_09_26_drive_0009_sync", "2011_09_26_drive_0002_sync"}) {
    const auto sequence = kittiDriveSequence(std::string(kitti) + "/2011_09_26", drive);
    const OdometryEvaluation result = evaluateOdometry(*sequence, EgoMotionParams());
    EXPECT_EQ(result.lost, 0) << drive;
    EXPECT_LT(std::abs(result.length_error_percent), 0.5) << drive;
  }
}

}  // namespace
}  // namespace predictive_stereo
