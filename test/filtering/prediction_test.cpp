#include "predictive_stereo/prediction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core/utility.hpp>

#include "every_target.h"

namespace predictive_stereo {
namespace {

const DisparityRange kRange{0, 128};

StereoRig rigOf(cv::Size size) {
  StereoRig rig;
  rig.size = size;
  rig.fx_px = rig.fy_px = 200;
  rig.cx_left_px = rig.cx_right_px = size.width / 2.0;
  rig.cy_px = size.height / 2.0;
  rig.baseline_m = 0.5;
  return rig;
}

DisparityState stateOf(const cv::Mat1f& disparity_px, float variance_px2) {
  DisparityState state;
  state.disparity_px = disparity_px.clone();
  state.variance_px2 = cv::Mat1f(disparity_px.size(), 0.0f);
  state.variance_px2.setTo(variance_px2, disparity_px >= kRange.min_disparity);
  state.missed_frames = cv::Mat1b(disparity_px.size(), uchar{0});
  return state;
}

CameraMotion forward(double metres) {
  CameraMotion motion;
  motion.T_cam_prev.translation().z() = -metres;
  return motion;
}

CameraMotion anyMotion() {
  CameraMotion motion;
  motion.T_cam_prev.linear() =
      Eigen::AngleAxisd(0.02, Eigen::Vector3d(0.3, 1, 0.1).normalized()).matrix();
  motion.T_cam_prev.translation() << 0.1, -0.05, -0.8;
  for (int i = 0; i < 6; ++i) motion.covariance(i, i) = 1e-4 * (i + 1);
  return motion;
}

// Eq. 2-4 pixel by pixel, in double precision, without filling and edges.
cv::Mat1f warpNaively(const DisparityState& state, const StereoRig& rig, const CameraMotion& motion,
                      cv::Mat1f& variance_px2) {
  cv::Mat1f disparity_px(rig.size, kRange.invalid());
  variance_px2 = cv::Mat1f(rig.size, 0.0f);
  for (int y = 0; y < rig.size.height; ++y) {
    for (int x = 0; x < rig.size.width; ++x) {
      const float d = state.disparity_px(y, x);
      if (!kRange.isValid(d) || d <= 0) continue;
      const Eigen::Vector3d point_m = motion.T_cam_prev * rig.pointFromDisparity(x, y, d);
      if (point_m.z() <= 0) continue;
      const Eigen::Vector3d omega = rig.disparityFromPoint(point_m);
      const int column = static_cast<int>(std::floor(omega.x() + 0.5));
      const int row = static_cast<int>(std::floor(omega.y() + 0.5));
      if (column < 0 || column >= rig.size.width || row < 0 || row >= rig.size.height) continue;
      if (omega.z() > kRange.max_disparity() || omega.z() <= disparity_px(row, column)) continue;
      const double phi = omega.z() / d;
      disparity_px(row, column) = static_cast<float>(omega.z());
      variance_px2(row, column) = static_cast<float>(phi * phi * state.variance_px2(y, x));
    }
  }
  return disparity_px;
}

cv::Mat1f smoothScene(cv::Size size) {
  cv::Mat1f disparity_px(size);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x)
      disparity_px(y, x) = 5.0f + 0.2f * y + 0.05f * x + 2.0f * std::sin(0.05f * x);
  cv::RNG rng(3);
  for (int i = 0; i < size.area() / 10; ++i)
    disparity_px(rng.uniform(0, size.height), rng.uniform(0, size.width)) = kRange.invalid();
  return disparity_px;
}

bool equal(const cv::Mat& a, const cv::Mat& b) { return cv::norm(a, b, cv::NORM_INF) == 0; }

TEST(Prediction, StandstillKeepsDisparityAndAddsProcessNoise) {
  const cv::Mat1f disparity_px = smoothScene({63, 41});
  PredictionParams params;
  Prediction prediction;
  Predictor(kRange, params)
      .predict(stateOf(disparity_px, 0.3f), rigOf(disparity_px.size()), CameraMotion(), prediction);
  for (int y = 0; y < disparity_px.rows; ++y)
    for (int x = 0; x < disparity_px.cols; ++x)
      if (kRange.isValid(disparity_px(y, x))) {
        EXPECT_NEAR(prediction.disparity_px(y, x), disparity_px(y, x), 1e-4);
        EXPECT_NEAR(prediction.variance_px2(y, x), 0.3 + params.process_noise_px2, 1e-5);
      }
}

TEST(Prediction, FollowsEveryPixelLikeTheNaiveWarp) {
  for (const cv::Size size : {cv::Size(97, 53), cv::Size(64, 1), cv::Size(1, 64)}) {
    PredictionParams params;
    params.edge_jump_px = 64;  // no resets
    const DisparityState state = stateOf(smoothScene(size), 0.3f);
    Prediction prediction;
    Predictor(kRange, params).predict(state, rigOf(size), anyMotion(), prediction);
    cv::Mat1f variance_px2;
    const cv::Mat1f expected = warpNaively(state, rigOf(size), anyMotion(), variance_px2);
    int compared = 0, different = 0;
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; ++x)
        if (kRange.isValid(expected(y, x))) {
          ++compared;
          // In single precision, a coordinate between two pixels may be rounded to either one.
          different += std::abs(prediction.disparity_px(y, x) - expected(y, x)) > 1e-3f ||
                       prediction.variance_px2(y, x) < variance_px2(y, x);
        }
    EXPECT_LE(different, compared / 200) << size;
    if (size.area() > 1000) {
      EXPECT_GT(compared, size.area() / 2);
    }
  }
}

TEST(Prediction, MotionCovarianceEntersThroughTheJacobian) {
  const cv::Size size(80, 60);
  const StereoRig rig = rigOf(size);
  CameraMotion motion;
  motion.covariance = Matrix6d::Identity() * 1e-4;
  motion.covariance(2, 3) = motion.covariance(3, 2) = 3e-5;
  motion.covariance(2, 4) = motion.covariance(4, 2) = -2e-5;
  motion.covariance(3, 4) = motion.covariance(4, 3) = 4e-5;
  PredictionParams params;
  Prediction prediction;
  Predictor(kRange, params).predict(stateOf(cv::Mat1f(size, 20.0f), 0.5f), rig, motion, prediction);
  for (const cv::Point at : {cv::Point(0, 0), cv::Point(79, 0), cv::Point(13, 59)}) {
    const Eigen::Vector3d point_m = rig.pointFromDisparity(at.x, at.y, 20.0);
    Vector6d jacobian;
    for (int i = 0; i < 6; ++i) {
      const Vector6d step = 1e-6 * Vector6d::Unit(i);
      const Eigen::Vector3d moved_m = point_m + step.head<3>() + step.tail<3>().cross(point_m);
      jacobian[i] = (rig.disparityFromPoint(moved_m).z() - 20.0) / 1e-6;
    }
    const double q = jacobian.dot(motion.covariance * jacobian);
    EXPECT_NEAR(prediction.variance_px2(at), 0.5 + params.process_noise_px2 + q, 1e-4);
  }
}

TEST(Prediction, NearerSurfaceWins) {
  // The camera moves sideways so that both pixels move to the same one.
  const cv::Size size(100, 3);
  const StereoRig rig = rigOf(size);
  cv::Mat1f disparity_px(size, kRange.invalid());
  disparity_px(1, 70) = 40;  // moves by 40
  disparity_px(1, 50) = 20;  // moves by 20
  CameraMotion motion;
  motion.T_cam_prev.translation().x() = -rig.baseline_m;
  Prediction prediction;
  Predictor(kRange, PredictionParams()).predict(stateOf(disparity_px, 1), rig, motion, prediction);
  EXPECT_FLOAT_EQ(prediction.disparity_px(1, 30), 40);
  EXPECT_EQ(cv::countNonZero(prediction.disparity_px != kRange.invalid()), 1);
}

TEST(Prediction, ForwardMotionLeavesNoHolesInASmoothSurface) {
  const cv::Size size(120, 80);
  Prediction prediction;
  Predictor(kRange, PredictionParams())
      .predict(stateOf(cv::Mat1f(size, 10.0f), 1), rigOf(size), forward(2.0), prediction);
  // From 10 m to 8 m: magnified by 1.25, so all of the current view was inside the previous image.
  EXPECT_EQ(cv::countNonZero(prediction.disparity_px == kRange.invalid()), 0);
  EXPECT_NEAR(prediction.disparity_px(40, 60), 12.5, 1e-4);
}

TEST(Prediction, DropsWhatPassesTheCameraOrComesTooNear) {
  const cv::Size size(60, 40);
  Prediction prediction;
  Predictor(kRange, PredictionParams())
      .predict(stateOf(cv::Mat1f(size, 50.0f), 1), rigOf(size), forward(2.5), prediction);
  EXPECT_EQ(cv::countNonZero(prediction.disparity_px != kRange.invalid()), 0);
  EXPECT_EQ(cv::countNonZero(prediction.variance_px2), 0);
}

TEST(Prediction, ResetsVarianceNearDiscontinuities) {
  const cv::Size size(40, 20);
  cv::Mat1f disparity_px(size, 10.0f);
  disparity_px.colRange(20, 40).setTo(30);
  PredictionParams params;
  Prediction prediction;
  Predictor(kRange, params)
      .predict(stateOf(disparity_px, 0.5f), rigOf(size), CameraMotion(), prediction);
  for (int x = 0; x < size.width; ++x) {
    const bool near = x >= 19 - params.edge_margin_px && x <= 19 + params.edge_margin_px;
    EXPECT_EQ(prediction.near_edge(10, x), near ? 255 : 0) << x;
    EXPECT_NEAR(prediction.variance_px2(10, x),
                near ? 128.0 * 128 / 12 : 0.5 + params.process_noise_px2, 1e-3)
        << x;
  }
}

// Jumps in both directions, among them in the last rows and columns.
DisparityState jumpyState(cv::Size size) {
  DisparityState state = stateOf(smoothScene(size), 0.3f);
  cv::RNG rng(7);
  for (int i = 0; i < size.area() / 40 + 1; ++i)
    state.disparity_px(rng.uniform(0, size.height), rng.uniform(0, size.width)) += 9.0f;
  rng.fill(state.missed_frames, cv::RNG::UNIFORM, 0, 4);
  return state;
}

const cv::Size kOddSizes[] = {{1, 1}, {2, 3}, {7, 5}, {8, 33}, {19, 2}, {64, 65}, {127, 70}};

TEST(Prediction, NearEdgesAreWithinTheMarginOfAJump) {
  for (const cv::Size size : kOddSizes)
    for (const int margin : {0, 1, 2, 10}) {
      PredictionParams params;
      params.edge_margin_px = margin;
      Prediction prediction;
      Predictor(kRange, params).predict(jumpyState(size), rigOf(size), anyMotion(), prediction);
      const cv::Mat1f& d = prediction.disparity_px;
      const auto jump = [&](cv::Point a, cv::Point b) {
        return b.x < size.width && b.y < size.height && kRange.isValid(d(a)) &&
               kRange.isValid(d(b)) && std::abs(d(a) - d(b)) > params.edge_jump_px;
      };
      cv::Mat1b expected(size, uchar{0});
      for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x)
          if (jump({x, y}, {x + 1, y}) || jump({x, y}, {x, y + 1}))
            expected(cv::Rect(x - margin, y - margin, 2 * margin + 1, 2 * margin + 1) &
                     cv::Rect({}, size)) = 255;
      ASSERT_EQ(cv::countNonZero(prediction.near_edge != expected), 0) << size << margin;
    }
}

// Rows first, then columns; each pass reads a copy that keeps its holes.
void fillNaively(cv::Point step, DisparityState& state) {
  const DisparityState given{state.disparity_px.clone(), state.variance_px2.clone(),
                             state.missed_frames.clone()};
  const cv::Rect image({}, given.disparity_px.size());
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const cv::Point p(x, y), before = p - step, after = p + step;
      if (!image.contains(before) || !image.contains(after) ||
          kRange.isValid(given.disparity_px(p)))
        continue;
      const float d0 = given.disparity_px(before), d2 = given.disparity_px(after);
      if (!kRange.isValid(d0) || !kRange.isValid(d2)) continue;
      state.disparity_px(p) = 0.5f * (d0 + d2);
      state.variance_px2(p) = 0.5f * (given.variance_px2(before) + given.variance_px2(after));
      state.missed_frames(p) = std::max(given.missed_frames(before), given.missed_frames(after));
    }
}

TEST(Prediction, FillsHolesBetweenKnownNeighbours) {
  PredictionParams params;
  params.use_motion_covariance = false;
  params.edge_jump_px = 64;  // no discontinuity, so that variances show
  forEveryTarget([&] {
    for (const cv::Size size : kOddSizes) {
      DisparityState state = jumpyState(size);
      cv::randu(state.variance_px2, 0.1, 2.0);
      for (int i = 0; i < size.area() / 3; ++i)
        state.disparity_px((7919 * i) % size.area() / size.width, (7919 * i) % size.width) =
            kRange.invalid();
      Prediction prediction;
      Predictor(kRange, params).predict(state, rigOf(size), CameraMotion(), prediction);
      fillNaively({1, 0}, state);
      fillNaively({0, 1}, state);
      for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x) {
          ASSERT_EQ(prediction.disparity_px(y, x), state.disparity_px(y, x))
              << size << x << "," << y;
          if (!kRange.isValid(state.disparity_px(y, x))) continue;
          ASSERT_EQ(prediction.missed_frames(y, x), state.missed_frames(y, x)) << size;
          ASSERT_EQ(prediction.variance_px2(y, x),
                    state.variance_px2(y, x) + static_cast<float>(params.process_noise_px2));
        }
    }
  });
}

TEST(Prediction, IsTheSameOnEveryTarget) {
  for (const cv::Size size : kOddSizes) {
    Prediction first;
    forEveryTarget([&] {
      Prediction prediction;
      Predictor(kRange, {}).predict(jumpyState(size), rigOf(size), anyMotion(), prediction);
      if (first.disparity_px.empty()) first = prediction;
      EXPECT_EQ(cv::countNonZero(prediction.disparity_px != first.disparity_px), 0) << size;
      EXPECT_EQ(cv::countNonZero(prediction.variance_px2 != first.variance_px2), 0) << size;
      EXPECT_EQ(cv::countNonZero(prediction.missed_frames != first.missed_frames), 0) << size;
      EXPECT_EQ(cv::countNonZero(prediction.near_edge != first.near_edge), 0) << size;
    });
  }
}

TEST(Prediction, DoesNotDependOnTheNumberOfThreads) {
  const cv::Size size(211, 157);
  const DisparityState state = stateOf(smoothScene(size), 0.3f);
  Prediction expected;
  const int threads = cv::getNumThreads();
  for (const int n : {1, 2, 3, 7}) {
    cv::setNumThreads(n);
    Prediction prediction;
    Predictor(kRange, PredictionParams()).predict(state, rigOf(size), anyMotion(), prediction);
    if (n == 1) expected = prediction;
    EXPECT_TRUE(equal(prediction.disparity_px, expected.disparity_px));
    EXPECT_TRUE(equal(prediction.variance_px2, expected.variance_px2));
    EXPECT_TRUE(equal(prediction.missed_frames, expected.missed_frames));
    EXPECT_TRUE(equal(prediction.near_edge, expected.near_edge));
  }
  cv::setNumThreads(threads);
}

TEST(Prediction, RefusesParametersByName) {
  PredictionParams params;
  params.edge_margin_px = -1;
  try {
    Predictor(kRange, params);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "prediction/edge_margin_px = -1: must be within [0, 10]");
  }
}

TEST(Prediction, RejectsWhatIsNearDiscontinuitiesWhereAskedTo) {
  cv::Mat1f disparity_px(60, 120, 10.0f);  // more than one band of rows
  disparity_px(cv::Rect(40, 30, 40, 30)) = 25.0f;
  DisparityState state = stateOf(disparity_px, 0.3f);
  state.missed_frames.setTo(1);
  PredictionParams params;
  Prediction reset, rejected;
  Predictor(kRange, params).predict(state, rigOf(disparity_px.size()), anyMotion(), reset);
  params.reject_near_edges = true;
  Predictor(kRange, params).predict(state, rigOf(disparity_px.size()), anyMotion(), rejected);
  EXPECT_TRUE(equal(reset.near_edge, rejected.near_edge));
  EXPECT_GT(cv::countNonZero(rejected.near_edge), 400);
  EXPECT_EQ(cv::countNonZero((rejected.disparity_px != kRange.invalid()) & rejected.near_edge), 0);
  EXPECT_EQ(cv::countNonZero((rejected.variance_px2 != 0) & rejected.near_edge), 0);
  EXPECT_EQ(cv::countNonZero(rejected.missed_frames & rejected.near_edge), 0);
  reset.disparity_px.setTo(kRange.invalid(), reset.near_edge);
  reset.variance_px2.setTo(0, reset.near_edge);
  EXPECT_TRUE(equal(reset.disparity_px, rejected.disparity_px)) << "the others stay as they are";
  EXPECT_TRUE(equal(reset.variance_px2, rejected.variance_px2));
}

}  // namespace
}  // namespace predictive_stereo
