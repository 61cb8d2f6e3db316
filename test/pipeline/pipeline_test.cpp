#include "predictive_stereo/pipeline.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <future>
#include <vector>

#include "simulation/street.h"

namespace predictive_stereo {
namespace {

constexpr int kFrames = 6;

StreetParams streetOf(const std::string& scene) {
  StreetParams params;
  params.scene = scene;
  params.width = 496;
  params.height = 160;
  params.frames = 200;
  return params;
}

DisparityParams disparityParams() {
  DisparityParams params;
  params.matcher.range.count = 64;
  return params;
}

CameraMotion trueMotion(const StreetFrame& previous, const StreetFrame& now) {
  CameraMotion motion;
  motion.T_cam_prev = now.T_world_cam.inverse() * previous.T_world_cam;
  motion.covariance = Matrix6d::Identity() * 1e-6;
  return motion;
}

// Share of the pixels with a known disparity that is wrong by more than 3 px and 5 % or missing.
double outliers(const StreetFrame& frame, const cv::Mat1f& disparity_px) {
  int known = 0, wrong = 0;
  for (int y = 0; y < disparity_px.rows; ++y)
    for (int x = 0; x < disparity_px.cols; ++x) {
      const float truth = frame.disparity_px(y, x);
      if (!(truth > 0) || truth >= 60) continue;
      ++known;
      const float error = std::abs(disparity_px(y, x) - truth);
      wrong += disparity_px(y, x) < 0 || (error > 3 && error > 0.05f * truth);
    }
  return static_cast<double>(wrong) / known;
}

// Matches frames of a street with their true motion, or with the motion that `motion` gives.
class DisparityEstimatorTest : public testing::Test {
 protected:
  using MotionOf =
      std::function<std::optional<CameraMotion>(const StreetFrame& past, const StreetFrame& now)>;

  void run(DisparityEstimator& estimator, const StreetFrame& frame, const MotionOf& motion) {
    estimator.prepare(frame.left, frame.right, street_.rig());
    estimator.estimate(past_.left.empty() ? std::nullopt : motion(past_, frame), output_);
    if (output_.carried) past_ = frame;
  }
  void run(DisparityEstimator& estimator, const StreetFrame& frame) {
    run(estimator, frame, trueMotion);
  }

  Street street_{streetOf("straight")};
  StreetFrame past_;
  DisparityOutput output_;
};

std::optional<CameraMotion> unknownMotion(const StreetFrame&, const StreetFrame&) {
  return std::nullopt;
}

TEST_F(DisparityEstimatorTest, PredictionIsUsedFromTheSecondFrameOn) {
  DisparityEstimator estimator(disparityParams());
  double outliers_without = 0, outliers_with = 0;
  for (int i = 0; i < kFrames; ++i) {
    const StreetFrame frame = street_.render(i);
    run(estimator, frame);
    EXPECT_EQ(output_.predicted, i > 0);
    EXPECT_TRUE(output_.carried);
    (i == 0 ? outliers_without : outliers_with) = outliers(frame, output_.disparity_px);
    EXPECT_EQ(cv::countNonZero((output_.disparity_px >= 0) != (output_.disparity_variance_px2 > 0)),
              0)
        << "each disparity has a variance, and nothing else has";
  }
  EXPECT_LT(outliers_without, 0.2);
  EXPECT_LT(outliers_with, outliers_without) << "prediction should help";
}

TEST_F(DisparityEstimatorTest, AFrameWithoutMotionCostsNoMoreThanItself) {
  DisparityEstimator estimator(disparityParams());
  for (int i = 0; i < kFrames; ++i) {
    const StreetFrame frame = street_.render(i);
    const bool without = i == 3;
    run(estimator, frame, without ? MotionOf(unknownMotion) : MotionOf(trueMotion));
    EXPECT_EQ(output_.predicted, i > 0 && !without) << i;
    EXPECT_EQ(output_.carried, !without) << i;
    if (without) {
      EXPECT_EQ(cv::countNonZero(output_.predicted_disparity_px >= 0), 0);
      EXPECT_LT(outliers(frame, output_.disparity_px), 0.2);
    }
  }
}

TEST_F(DisparityEstimatorTest, ThePastIsGivenUpAfterSomeFramesWithoutMotion) {
  DisparityEstimator estimator(disparityParams());
  const int patience = disparityParams().correction.max_missed_frames;
  run(estimator, street_.render(0));
  for (int i = 1; i <= patience + 1; ++i) {
    run(estimator, street_.render(i), unknownMotion);
    EXPECT_EQ(output_.carried, i > patience) << i;
  }
  run(estimator, street_.render(patience + 2));
  EXPECT_TRUE(output_.predicted);
}

TEST_F(DisparityEstimatorTest, WhatMovedIsNoPast) {
  DisparityParams params = disparityParams();
  params.row_alignment.enabled = false;  // it has a past, too
  DisparityEstimator estimator(params), fresh(params);
  run(estimator, street_.render(0));
  const cv::Mat1b everything(street_.rig().size, uchar{255});
  estimator.markMoving(everything);
  const StreetFrame frame = street_.render(1);
  run(estimator, frame);
  EXPECT_TRUE(output_.predicted);
  EXPECT_GT(cv::countNonZero(output_.predicted_disparity_px >= 0), frame.left.rows);
  const DisparityOutput marked = std::exchange(output_, DisparityOutput());
  past_ = StreetFrame();
  run(fresh, frame);
  EXPECT_EQ(cv::norm(marked.search_width_px, output_.search_width_px, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(marked.measured_disparity_px, output_.measured_disparity_px, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(marked.disparity_px, output_.disparity_px, cv::NORM_INF), 0);
}

TEST_F(DisparityEstimatorTest, WhatMovedIsAPastWhereSoAsked) {
  DisparityParams params = disparityParams();
  params.use_moving_mask = false;
  DisparityEstimator marked(params), other(params);
  const cv::Mat1b everything(street_.rig().size, uchar{255});
  cv::Mat1f expected;
  for (DisparityEstimator* estimator : {&marked, &other}) {
    past_ = StreetFrame();
    run(*estimator, street_.render(0));
    if (estimator == &marked) estimator->markMoving(everything);
    run(*estimator, street_.render(1));
    if (estimator == &marked) expected = output_.disparity_px.clone();
  }
  EXPECT_EQ(cv::norm(expected, output_.disparity_px, cv::NORM_INF), 0);
}

TEST_F(DisparityEstimatorTest, RefusesAMaskOfAnotherSize) {
  DisparityEstimator estimator(disparityParams());
  run(estimator, street_.render(0));
  EXPECT_THROW(estimator.markMoving(cv::Mat1b::zeros(4, 4)), std::invalid_argument);
}

TEST_F(DisparityEstimatorTest, ResetStartsAnewBitByBit) {
  DisparityEstimator used(disparityParams()), fresh(disparityParams());
  for (int i = 0; i < 3; ++i) run(used, street_.render(i));
  used.reset();
  past_ = StreetFrame();
  run(used, street_.render(7));
  const cv::Mat1f expected = output_.disparity_px.clone();
  past_ = StreetFrame();
  output_ = DisparityOutput();
  run(fresh, street_.render(7));
  EXPECT_EQ(cv::norm(expected, output_.disparity_px, cv::NORM_INF), 0);
}

TEST_F(DisparityEstimatorTest, WritesIntoTheCallersMemory) {
  DisparityEstimator estimator(disparityParams());
  const StreetFrame frame = street_.render(0);
  for (cv::Mat1f* map : {&output_.disparity_px, &output_.disparity_variance_px2,
                         &output_.measured_disparity_px, &output_.measured_variance_px2,
                         &output_.predicted_disparity_px, &output_.predicted_variance_px2})
    map->create(frame.left.size());
  output_.search_width_px.create(frame.left.size());
  const DisparityOutput memory = output_;
  run(estimator, frame);
  EXPECT_EQ(output_.disparity_px.data, memory.disparity_px.data);
  EXPECT_EQ(output_.disparity_variance_px2.data, memory.disparity_variance_px2.data);
  EXPECT_EQ(output_.measured_disparity_px.data, memory.measured_disparity_px.data);
  EXPECT_EQ(output_.measured_variance_px2.data, memory.measured_variance_px2.data);
  EXPECT_EQ(output_.predicted_disparity_px.data, memory.predicted_disparity_px.data);
  EXPECT_EQ(output_.predicted_variance_px2.data, memory.predicted_variance_px2.data);
  EXPECT_EQ(output_.search_width_px.data, memory.search_width_px.data);
}

TEST_F(DisparityEstimatorTest, WrongMotionDoesNotStickToTheFilters) {
  DisparityEstimator estimator(disparityParams());
  DisparityParams full_params = disparityParams();
  full_params.search.scheme = SearchScheme::kFull;
  DisparityEstimator full(full_params);
  const auto sometimesWrong = [](const StreetFrame& past, const StreetFrame& now) {
    CameraMotion motion = trueMotion(past, now);
    if (now.index % 10 == 5) {
      motion.T_cam_prev.translation().z() += 0.3;
      motion.T_cam_prev.rotate(Eigen::AngleAxisd(M_PI / 180, Eigen::Vector3d::UnitY()));
    }
    return std::optional(motion);
  };
  double ours = 0, reference = 0;
  for (int i = 0; i < 100; ++i) {
    const StreetFrame frame = street_.render(i);
    const StreetFrame past = past_;
    run(estimator, frame, sometimesWrong);
    if (i > 0) ours += outliers(frame, output_.disparity_px);
    past_ = past;
    run(full, frame, sometimesWrong);
    if (i > 0) reference += outliers(frame, output_.disparity_px);
  }
  EXPECT_LE(ours, 1.2 * reference);
}

TEST_F(DisparityEstimatorTest, ThePapersSchemeWorksWithAndWithoutRowAlignment) {
  for (const bool aligned : {true, false}) {
    DisparityParams params = disparityParams();
    params.search.scheme = SearchScheme::kPaper;
    params.row_alignment.enabled = aligned;
    params.matcher.census = CensusForm::k5x5;
    params.matcher.p1 = 6;
    params.matcher.p2 = 65;
    DisparityEstimator estimator(params);
    past_ = StreetFrame();
    for (int i = 0; i < 3; ++i) {
      const StreetFrame frame = street_.render(i);
      run(estimator, frame);
      EXPECT_LT(outliers(frame, output_.disparity_px), 0.25);
    }
    EXPECT_LT(cv::mean(output_.search_width_px)[0], 40) << "most pixels are searched in part";
  }
}

TEST_F(DisparityEstimatorTest, PredictsBeforeBesideOrAfterTheHalfResolutionMatch) {
  std::vector<std::function<void(DisparityEstimator&, const std::function<void()>&)>> orders;
  orders.push_back([](DisparityEstimator& estimator, const auto& predict) {
    estimator.matchCoarsely();
    predict();
  });
  orders.push_back([](DisparityEstimator& estimator, const auto& predict) {
    predict();
    estimator.matchCoarsely();
  });
  orders.push_back([](DisparityEstimator& estimator, const auto& predict) {
    auto matched = std::async(std::launch::async, [&] { estimator.matchCoarsely(); });
    predict();
    matched.get();
  });
  std::vector<cv::Mat1f> disparities_px;
  for (const auto& inOrder : orders) {
    DisparityEstimator estimator(disparityParams());
    DisparityOutput output;
    StreetFrame past;
    for (int i = 0; i < 4; ++i) {
      const StreetFrame frame = street_.render(i);
      estimator.begin(frame.left, frame.right, street_.rig());
      inOrder(estimator, [&] {
        estimator.predict(i > 0 ? std::optional(trueMotion(past, frame)) : std::nullopt, output);
      });
      estimator.measure(output);
      estimator.publish(output);
      past = frame;
    }
    EXPECT_STREQ(estimator.times().front().name, "half-resolution match");
    disparities_px.push_back(output.disparity_px.clone());
  }
  EXPECT_EQ(cv::norm(disparities_px[0], disparities_px[1], cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(disparities_px[0], disparities_px[2], cv::NORM_INF), 0);
}

TEST_F(DisparityEstimatorTest, RefusesImagesThatDoNotFitTheCalibration) {
  DisparityEstimator estimator(disparityParams());
  const cv::Mat1b image(100, 200, uchar{0});
  try {
    estimator.prepare(image, image, street_.rig());
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "left image is 200x100 but the calibration is for 496x160");
  }
}

TEST(DisparityEstimatorAtRest, VarianceStaysBoundedAndDisparityUnbiased) {
  // Six hundred frames stand for ten minutes at one frame per second; a few noise patterns in turn.
  const Street street(streetOf("standstill"));
  std::vector<StreetFrame> frames;
  for (int i = 0; i < 5; ++i) frames.push_back(street.render(i));
  DisparityEstimator estimator(disparityParams());
  CameraMotion rest;
  rest.covariance = Matrix6d::Identity() * 1e-8;
  DisparityOutput output;
  std::vector<double> bias, sigma;
  for (int i = 0; i < 600; ++i) {
    const StreetFrame& frame = frames[i % frames.size()];
    estimator.prepare(frame.left, frame.right, street.rig());
    estimator.estimate(i > 0 ? std::optional(rest) : std::nullopt, output);
    if (i != 5 && i != 599) continue;
    cv::Mat1f error = output.disparity_px - frame.disparity_px;
    const cv::Mat good = (cv::abs(error) < 1) & (frame.disparity_px > 0);
    bias.push_back(cv::mean(error, good)[0]);
    double smallest;
    cv::minMaxLoc(output.disparity_variance_px2, &smallest, nullptr, nullptr, nullptr,
                  output.disparity_px >= 0);
    sigma.push_back(std::sqrt(smallest));
  }
  EXPECT_LT(std::abs(bias[1]), 0.1);
  EXPECT_LT(std::abs(bias[1] - bias[0]), 0.03);
  EXPECT_GT(sigma[1], 0.2);
}

TEST(Pipeline, FollowsTheStreetEndToEnd) {
  const Street street(streetOf("straight"));
  PipelineParams params;
  params.disparity = disparityParams();
  params.detection.range = params.disparity.matcher.range;
  Pipeline pipeline(params);
  PipelineOutput output;
  StreetFrame first, frame;
  double wrong = 0;
  for (int i = 0; i < kFrames; ++i) {
    frame = street.render(i);
    if (i == 0) first = frame;
    pipeline.process(frame.left, frame.right, street.rig(), frame.stamp_s, output);
    wrong = outliers(frame, output.disparity.disparity_px);
    EXPECT_EQ(output.disparity.predicted, i > 0);
  }
  const Eigen::Isometry3d T_first_cam = first.T_world_cam.inverse() * frame.T_world_cam;
  const double distance_m = T_first_cam.translation().norm();
  EXPECT_GT(distance_m, 1.0);
  EXPECT_LT((output.T_odom_cam.translation() - T_first_cam.translation()).norm(),
            0.05 * distance_m);
  EXPECT_LT(wrong, 0.15);
  EXPECT_EQ(output.detections.mask.size(), frame.left.size());
}

}  // namespace
}  // namespace predictive_stereo
