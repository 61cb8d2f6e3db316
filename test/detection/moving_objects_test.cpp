#include "predictive_stereo/moving_objects.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "detection/board_scene.h"

namespace predictive_stereo {
namespace {

DetectionInput emptyFrame() {
  DetectionInput input;
  input.rig.size = {600, 300};
  input.rig.fx_px = input.rig.fy_px = 400;
  input.rig.cx_left_px = input.rig.cx_right_px = 300;
  input.rig.cy_px = 140;
  input.rig.baseline_m = 0.5;
  input.left = cv::Mat1b(input.rig.size, 100);
  input.measured_disparity_px = cv::Mat1f(input.rig.size, 10.0f);
  input.predicted_disparity_px = cv::Mat1f(input.rig.size, 10.0f);
  input.measured_variance_px2 = cv::Mat1f(input.rig.size, 0.25f);
  input.predicted_variance_px2 = cv::Mat1f(input.rig.size, 0.25f);
  input.pose_state = PoseState::kKnown;
  return input;
}

TEST(MovingObjectDetector, PaperFindsWhatChangesDisparity) {
  DetectionParams params;
  params.scheme = DetectionScheme::kPaper;
  MovingObjectDetector detector(params);
  DetectionInput input = emptyFrame();
  const cv::Rect car(200, 130, 80, 60);
  input.measured_disparity_px(car) = 20.0f;
  Detections found;
  detector.detect(input, found);
  ASSERT_EQ(found.objects.size(), 1u);
  const DetectedObject& object = found.objects[0];
  EXPECT_EQ(cv::Rect(object.box_px) & car, car);
  EXPECT_NEAR(object.distance_m, 10.0, 1e-6);
  EXPECT_NEAR(object.centre_m.x(), (239.5 - 300) * 10 / 400, 0.05);
  EXPECT_NEAR(object.centre_m.z(), 10.0, 1e-6);
  EXPECT_EQ(cv::countNonZero(found.mask), car.area());
  EXPECT_EQ(cv::countNonZero(found.mask(car)), car.area());
  const int id = object.id;
  input.stamp_s = 0.1;
  detector.detect(input, found);
  ASSERT_EQ(found.objects.size(), 1u);
  EXPECT_EQ(found.objects[0].id, id);
  EXPECT_EQ(found.objects[0].age, 2);
}

// The odom frame has z up: seen in it, what is ahead of the camera is not ahead of its origin.
TEST(MovingObjectDetector, AFrameWithoutPoseLeavesTracksAsTheyAre) {
  DetectionParams params;
  params.scheme = DetectionScheme::kPaper;
  MovingObjectDetector detector(params);
  DetectionInput input = emptyFrame();
  const cv::Rect car(200, 130, 80, 60);
  input.measured_disparity_px(car) = 20.0f;
  Eigen::Isometry3d T_odom_cam = Eigen::Isometry3d::Identity();
  T_odom_cam.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  T_odom_cam.translation() = Eigen::Vector3d(100, 50, 2);
  Detections first, found;
  for (int k = 0; k < 9; ++k) {
    const bool has_pose = k < 3 || k > 4;
    input.stamp_s = 0.1 * k;
    input.pose_state = has_pose ? PoseState::kKnown : PoseState::kLost;
    input.T_odom_cam = has_pose ? T_odom_cam : Eigen::Isometry3d::Identity();
    detector.detect(input, k == 0 ? first : found);
    if (k == 0) continue;
    ASSERT_EQ(found.objects.size(), 1u) << k;
    const DetectedObject &before = first.objects.at(0), &object = found.objects[0];
    EXPECT_EQ(object.id, before.id) << k;
    EXPECT_EQ(object.box_px, before.box_px) << k;
    EXPECT_TRUE(object.centre_m.isApprox(before.centre_m)) << k;
    EXPECT_LT(object.velocity_mps.norm(), 1e-6) << k;
  }
}

// It is found, but its place in the odom frame is not known before the first pose.
TEST(MovingObjectDetector, WithoutAnyPoseThereIsNoVelocity) {
  DetectionParams params;
  params.scheme = DetectionScheme::kPaper;
  MovingObjectDetector detector(params);
  DetectionInput input = emptyFrame();
  input.measured_disparity_px(cv::Rect(200, 130, 80, 60)) = 20.0f;
  Detections found;
  for (int k = 0; k < 3; ++k) {
    input.stamp_s = 0.1 * k;
    input.pose_state = k < 2 ? PoseState::kLost : PoseState::kKnown;
    detector.detect(input, found);
    ASSERT_EQ(found.objects.size(), 1u) << k;
    EXPECT_EQ(found.objects[0].age, k + 1);
    EXPECT_EQ(found.objects[0].velocity_covariance.isZero(), k < 2) << "zero: not known";
  }
}

// Somebody walks to the right before a wall; two poses are missing.
TEST(MovingObjectDetector, FramesWithoutPoseDoNotEndATrack) {
  for (const bool seen_after : {true, false}) {
    SCOPED_TRACE(seen_after);
    MovingObjectDetector detector{DetectionParams()};
    std::vector<int> ids;
    for (int k = 0; k < 14; ++k) {
      const BoardScene scene{{wallAt(20), {-2 + 0.25 * k, -0.2, 0.6, 1.7, 5}}, 1.5};
      BoardView view = viewOf(scene, 0.1 * k);
      view.input.predicted_disparity_px = view.input.measured_disparity_px;
      view.input.predicted_variance_px2 = view.input.measured_variance_px2;
      if (k == 7 || k == 8) view.input.pose_state = PoseState::kLost;
      if (k == 9 && !seen_after) view.input.motion_covariance = unseenCovariance();
      Detections found;
      detector.detect(view.input, found);
      for (const DetectedObject& object : found.objects) ids.push_back(object.id);
      if (k == 6 || k > 11) {
        EXPECT_EQ(found.objects.size(), 1u) << k;
      }
    }
    ASSERT_FALSE(ids.empty());
    EXPECT_EQ(ids, std::vector<int>(ids.size(), ids[0]));
  }
}

// Somebody walks to the right; the camera's driver sends one image three times, with new stamps.
TEST(MovingObjectDetector, AnImageThatIsShownAgainHasTheSameObjects) {
  MovingObjectDetector detector{DetectionParams()};
  std::vector<Detections> found(14);
  for (int k = 0; k < 14; ++k) {
    const int shown = k == 8 || k == 9 ? 7 : k;
    const BoardScene scene{{wallAt(20), {-2 + 0.25 * shown, -0.2, 0.6, 1.7, 5}}, 1.5};
    detector.detect(viewOf(scene, 0.1 * k).input, found[k]);
  }
  ASSERT_EQ(found[7].objects.size(), 1u);
  const DetectedObject& shown = found[7].objects[0];
  for (int k = 8; k < 14; ++k) {
    ASSERT_EQ(found[k].objects.size(), 1u) << k;
    const DetectedObject& object = found[k].objects[0];
    EXPECT_EQ(object.id, shown.id) << k;
    EXPECT_NEAR(object.velocity_mps.x(), 2.5, 0.3) << k;
    if (k > 9) continue;
    EXPECT_EQ(object.box_px, shown.box_px) << k;
    EXPECT_EQ(cv::norm(found[k].mask, found[7].mask, cv::NORM_INF), 0) << k;
  }
}

// Poses come from elsewhere, and go on.
TEST(MovingObjectDetector, AFrozenCameraShowsNothingThatMoves) {
  MovingObjectDetector detector{DetectionParams()};
  Detections found;
  for (int k = 0; k < 25; ++k) {
    const BoardScene scene{{wallAt(20), {-2 + 0.25 * std::min(k, 7), -0.2, 0.6, 1.7, 5}}, 1.5};
    BoardView view = viewOf(scene, 0.1 * k);
    view.input.T_odom_cam.translation().z() += 0.05 * std::max(k - 7, 0);
    detector.detect(view.input, found);
    if (k == 7) {
      EXPECT_EQ(found.objects.size(), 1u);
    }
  }
  EXPECT_TRUE(found.objects.empty());
}

// Wheels slip to and fro while an image is shown again, and say how uncertain they are: nothing has
// moved.
TEST(MovingObjectDetector, TheCovarianceOfAnImageThatIsShownAgainCounts) {
  MovingObjectDetector detector{DetectionParams()};
  const BoardScene scene{{wallAt(20), {-0.3, -0.2, 0.6, 1.7, 5}}, 1.5};
  double slipped_m = 0;
  for (int k = 0; k < 24; ++k) {
    BoardView view = viewOf(scene, 0.1 * k);
    const bool is_again = k > 3 && k % 2 == 0;
    view.input.left(0, 0) = static_cast<uchar>(is_again ? k - 1 : k);  // all else is the same
    if (is_again) {
      slipped_m = 0.1 - slipped_m;
      view.input.motion_covariance.diagonal().head<3>().setConstant(0.01);
    }
    view.input.T_odom_cam.translation().x() = slipped_m;
    Detections found;
    detector.detect(view.input, found);
    EXPECT_TRUE(found.objects.empty()) << k;
  }
}

TEST(MovingObjectDetector, IdsGoOnAfterAChangeOfTheRange) {
  DetectionParams params;
  params.scheme = DetectionScheme::kPaper;
  MovingObjectDetector detector(params);
  DetectionInput input = emptyFrame();
  input.measured_disparity_px(cv::Rect(200, 130, 80, 60)) = 20.0f;
  Detections found;
  detector.detect(input, found);
  const int id = found.objects.at(0).id;
  params.range = {0, 64};
  detector.setParams(params);
  input.stamp_s = 0.1;
  detector.detect(input, found);
  EXPECT_GT(found.objects.at(0).id, id) << "the tracks are not kept";
}

TEST(MovingObjectDetector, NothingPredictedNothingFound) {
  DetectionParams params;
  params.scheme = DetectionScheme::kPaper;
  MovingObjectDetector detector(params);
  DetectionInput input = emptyFrame();
  const cv::Rect car(200, 130, 80, 60);
  input.measured_disparity_px(car) = 20.0f;
  input.predicted_disparity_px(car) = -1.0f;
  Detections found;
  detector.detect(input, found);
  EXPECT_TRUE(found.objects.empty());
  EXPECT_EQ(cv::countNonZero(found.mask), 0);
}

TEST(MovingObjectDetector, RefusesWrongSizes) {
  DetectionParams params;
  Detections found;
  const auto refusalOf = [&](const DetectionInput& input) -> std::string {
    try {
      MovingObjectDetector(params).detect(input, found);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  DetectionInput input = emptyFrame();
  input.measured_variance_px2 = cv::Mat1f(20, 30);
  EXPECT_EQ(refusalOf(input), "measured variance is 30x20 but the calibration is for 600x300");
  // Only the paper's scheme needs predicted maps.
  input = emptyFrame();
  input.predicted_variance_px2 = cv::Mat1f(20, 30);
  EXPECT_EQ(refusalOf(input), "");
  input.predicted_disparity_px = input.predicted_variance_px2 = cv::Mat1f();
  EXPECT_EQ(refusalOf(input), "");
  params.scheme = DetectionScheme::kPaper;
  EXPECT_EQ(refusalOf(input), "predicted disparity is 0x0 but the calibration is for 600x300");
}

TEST(MovingObjectDetector, RefusesBadParameters) {
  DetectionParams params;
  params.paper.step_px = 0;
  EXPECT_THROW(MovingObjectDetector{params}, std::invalid_argument);
  params = DetectionParams();
  params.paper.largest_window_width_px = 10;
  EXPECT_THROW(MovingObjectDetector{params}, std::invalid_argument);
  params = DetectionParams();
  params.tracking.confirm_frames = 0;
  EXPECT_THROW(MovingObjectDetector{params}, std::invalid_argument);
}

TEST(MovingObjectDetector, RefusesSizesThatNoObjectHas) {
  DetectionParams params;
  params.motion.min_height_m = 5;
  try {
    MovingObjectDetector detector{params};
    FAIL() << "nothing would ever be found";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(),
                 "motion/min_height_m = 5: must not be above motion/max_height_m = 4.5");
  }
  params.motion.max_height_m = 5;
  EXPECT_NO_THROW(MovingObjectDetector{params});
  params.motion.min_width_m = 9.5;
  EXPECT_THROW(MovingObjectDetector{params}, std::invalid_argument);
}

}  // namespace
}  // namespace predictive_stereo
