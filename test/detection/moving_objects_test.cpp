#include "predictive_stereo/moving_objects.h"

#include <gtest/gtest.h>

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
  MovingObjectDetector detector{DetectionParams()};
  DetectionInput input = emptyFrame();
  input.predicted_variance_px2 = cv::Mat1f(20, 30);
  Detections found;
  try {
    detector.detect(input, found);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "predicted variance is 30x20 but the calibration is for 600x300");
  }
}

TEST(MovingObjectDetector, RefusesBadParameters) {
  DetectionParams params;
  params.paper.step_px = 0;
  EXPECT_THROW(MovingObjectDetector{params}, std::invalid_argument);
  params = DetectionParams();
  params.paper.largest_window_width_px = 10;
  EXPECT_THROW(MovingObjectDetector{params}, std::invalid_argument);
}

}  // namespace
}  // namespace predictive_stereo
