#include "predictive_stereo/pipeline.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "evaluation/simulation/street.h"

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

// Share of outliers (errors of more than 3 px and 5 %) and missing disparities, of pixels with
// truth.
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

DisparityLoop disparityAlone(const DisparityParams& disparity = disparityParams()) {
  return {disparity, PipelineParams().max_gap};
}

StereoFrame stereoFrame(const StreetFrame& frame, const StereoRig& rig, int number) {
  return {frame.left, frame.right, rig, number * std::chrono::milliseconds(100)};
}

// Runs only disparity on frames of a street, with their true motion or with that of `motion`.
class Loop : public testing::Test {
 protected:
  using MotionOf =
      std::function<std::optional<CameraMotion>(const StreetFrame& past, const StreetFrame& now)>;

  void run(DisparityLoop& loop, const StreetFrame& frame, const MotionOf& motion = trueMotion,
           const cv::Mat1b& moved = {}) {
    const auto since_past = [&](const Past& past) -> std::optional<CameraMotion> {
      if (!past.stamp()) return {};
      return motion(frames_.at(*past.stamp()), frame);
    };
    const auto movedBefore = [&](Stamp before) {
      EXPECT_EQ(before, stereoFrame(frame, street_.rig(), number_ - 2).stamp);
      return moved;
    };
    const StereoFrame now = stereoFrame(frame, street_.rig(), number_++);
    frames_[now.stamp] = frame;
    loop.begin(now);
    loop.measure(since_past, movedBefore, maps_);
    loop.publish(maps_);
    carried_ = loop.past().stamp() == now.stamp;
  }
  void startAnew() {
    frames_.clear();
    maps_ = DisparityOutput();
  }

  Street street_{streetOf("straight")};
  std::map<Stamp, StreetFrame> frames_;
  int number_ = 0;
  DisparityOutput maps_;
  bool carried_ = false;  // whether the frame is the past of the next one
};

std::optional<CameraMotion> unknownMotion(const StreetFrame&, const StreetFrame&) {
  return std::nullopt;
}

// Without a past, what is published are measured disparities, filled holes, and the median.
TEST_F(Loop, AMaxHoleOfZeroFillsNone) {
  const StreetFrame frame = street_.render(0);
  const auto publishedInHoles = [&](int max_hole_px) {
    startAnew();
    DisparityParams params = disparityParams();
    params.max_hole_px = max_hole_px;
    DisparityLoop loop(disparityAlone(params));
    run(loop, frame);
    const cv::Mat1b measured = (maps_.measured_disparity_px >= 0) / 255;
    cv::Mat1b neighbours;
    cv::boxFilter(measured, neighbours, CV_8U, {3, 3}, {-1, -1}, false);
    const cv::Mat1b in_holes =
        (maps_.disparity_px >= 0) & (maps_.measured_disparity_px < 0) & (neighbours < 5);
    return cv::countNonZero(in_holes(cv::Rect(1, 1, in_holes.cols - 2, in_holes.rows - 2)));
  };
  EXPECT_EQ(publishedInHoles(0), 0);
  EXPECT_GT(publishedInHoles(40), 500);
}

TEST_F(Loop, PredictionIsUsedFromTheSecondFrameOn) {
  DisparityLoop pipeline(disparityAlone());
  double outliers_without = 0, outliers_with = 0;
  for (int i = 0; i < kFrames; ++i) {
    const StreetFrame frame = street_.render(i);
    run(pipeline, frame);
    EXPECT_EQ(maps_.predicted, i > 0);
    EXPECT_TRUE(carried_);
    (i == 0 ? outliers_without : outliers_with) = outliers(frame, maps_.disparity_px);
    EXPECT_EQ(cv::countNonZero((maps_.disparity_px >= 0) != (maps_.disparity_variance_px2 > 0)), 0)
        << "each disparity has a variance, and nothing else has";
  }
  EXPECT_LT(outliers_without, 0.2);
  EXPECT_LT(outliers_with, outliers_without) << "prediction should help";
}

TEST_F(Loop, AFrameWithoutMotionCostsNoMoreThanItself) {
  DisparityLoop pipeline(disparityAlone());
  for (int i = 0; i < kFrames; ++i) {
    const StreetFrame frame = street_.render(i);
    const bool without = i == 3;
    run(pipeline, frame, without ? MotionOf(unknownMotion) : MotionOf(trueMotion));
    EXPECT_EQ(maps_.predicted, i > 0 && !without) << i;
    EXPECT_EQ(carried_, !without) << i;
    if (without) {
      EXPECT_EQ(cv::countNonZero(maps_.predicted_disparity_px >= 0), 0);
      EXPECT_LT(outliers(frame, maps_.disparity_px), 0.2);
    }
  }
}

TEST_F(Loop, ThePastIsGivenUpAfterSomeFramesWithoutMotion) {
  DisparityLoop pipeline(disparityAlone());
  const int patience = disparityParams().correction.max_missed_frames;
  run(pipeline, street_.render(0));
  for (int i = 1; i <= patience + 1; ++i) {
    run(pipeline, street_.render(i), unknownMotion);
    EXPECT_EQ(carried_, i > patience) << i;
  }
  run(pipeline, street_.render(patience + 2));
  EXPECT_TRUE(maps_.predicted);
}

TEST_F(Loop, WhatMovedIsNoPast) {
  DisparityParams params = disparityParams();
  params.row_alignment.enabled = false;  // because it has a state as well
  DisparityLoop pipeline(disparityAlone(params)), fresh(disparityAlone(params));
  run(pipeline, street_.render(0));
  const cv::Mat1b everything(street_.rig().size, uchar{255});
  const StreetFrame frame = street_.render(1);
  run(pipeline, frame, trueMotion, everything);
  EXPECT_TRUE(maps_.predicted);
  EXPECT_GT(cv::countNonZero(maps_.predicted_disparity_px >= 0), frame.left.rows);
  const DisparityOutput marked = maps_;
  startAnew();
  run(fresh, frame);
  EXPECT_EQ(cv::norm(marked.search_width_px, maps_.search_width_px, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(marked.measured_disparity_px, maps_.measured_disparity_px, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(marked.disparity_px, maps_.disparity_px, cv::NORM_INF), 0);
}

TEST_F(Loop, WhatMovedIsAPastWhereSoAsked) {
  DisparityParams params = disparityParams();
  params.use_moving_mask = false;
  DisparityLoop marked(disparityAlone(params)), other(disparityAlone(params));
  const cv::Mat1b everything(street_.rig().size, uchar{255});
  cv::Mat1f expected;
  for (DisparityLoop* pipeline : {&marked, &other}) {
    startAnew();
    run(*pipeline, street_.render(0));
    run(*pipeline, street_.render(1), trueMotion, pipeline == &marked ? everything : cv::Mat1b());
    if (pipeline == &marked) expected = maps_.disparity_px.clone();
  }
  EXPECT_EQ(cv::norm(expected, maps_.disparity_px, cv::NORM_INF), 0);
}

TEST_F(Loop, RefusesAMaskOfAnotherSize) {
  DisparityLoop pipeline(disparityAlone());
  run(pipeline, street_.render(0));
  EXPECT_THROW(run(pipeline, street_.render(1), trueMotion, cv::Mat1b::zeros(4, 4)),
               std::invalid_argument);
}

TEST_F(Loop, ResetStartsAnewBitByBit) {
  DisparityLoop used(disparityAlone()), fresh(disparityAlone());
  for (int i = 0; i < 3; ++i) run(used, street_.render(i));
  used.reset();
  run(used, street_.render(7));
  const cv::Mat1f expected = maps_.disparity_px.clone();
  startAnew();
  run(fresh, street_.render(7));
  EXPECT_EQ(cv::norm(expected, maps_.disparity_px, cv::NORM_INF), 0);
}

TEST_F(Loop, WritesIntoTheCallersMemory) {
  DisparityLoop pipeline(disparityAlone());
  const StreetFrame frame = street_.render(0);
  for (cv::Mat1f* map :
       {&maps_.disparity_px, &maps_.disparity_variance_px2, &maps_.measured_disparity_px,
        &maps_.measured_variance_px2, &maps_.predicted_disparity_px, &maps_.predicted_variance_px2})
    map->create(frame.left.size());
  maps_.search_width_px.create(frame.left.size());
  const DisparityOutput memory = maps_;
  run(pipeline, frame);
  EXPECT_EQ(maps_.disparity_px.data, memory.disparity_px.data);
  EXPECT_EQ(maps_.disparity_variance_px2.data, memory.disparity_variance_px2.data);
  EXPECT_EQ(maps_.measured_disparity_px.data, memory.measured_disparity_px.data);
  EXPECT_EQ(maps_.measured_variance_px2.data, memory.measured_variance_px2.data);
  EXPECT_EQ(maps_.predicted_disparity_px.data, memory.predicted_disparity_px.data);
  EXPECT_EQ(maps_.predicted_variance_px2.data, memory.predicted_variance_px2.data);
  EXPECT_EQ(maps_.search_width_px.data, memory.search_width_px.data);
}

TEST_F(Loop, WrongMotionDoesNotStickToTheFilters) {
  DisparityLoop pipeline(disparityAlone());
  DisparityParams full_params = disparityParams();
  full_params.search.scheme = SearchScheme::kFull;
  DisparityLoop full(disparityAlone(full_params));
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
    run(pipeline, frame, sometimesWrong);
    if (i > 0) ours += outliers(frame, maps_.disparity_px);
    --number_;  // the same frame again
    run(full, frame, sometimesWrong);
    if (i > 0) reference += outliers(frame, maps_.disparity_px);
  }
  EXPECT_LE(ours, 1.2 * reference);
}

TEST_F(Loop, ThePapersSchemeWorksWithAndWithoutRowAlignment) {
  for (const bool aligned : {true, false}) {
    DisparityParams params = disparityParams();
    params.search.scheme = SearchScheme::kPaper;
    params.row_alignment.enabled = aligned;
    params.matcher.census = CensusForm::k5x5;
    params.matcher.p1 = 6;
    params.matcher.p2 = 65;
    DisparityLoop pipeline(disparityAlone(params));
    startAnew();
    for (int i = 0; i < 3; ++i) {
      const StreetFrame frame = street_.render(i);
      run(pipeline, frame);
      EXPECT_LT(outliers(frame, maps_.disparity_px), 0.25);
    }
    EXPECT_LT(cv::mean(maps_.search_width_px)[0], 40) << "most pixels are searched in part";
  }
}

// The paper's scheme does not use it; row alignment does.
TEST_F(Loop, HalfResolutionIsMatchedOnlyWhereItIsUsed) {
  const StreetFrame frame = street_.render(0);
  const auto isMatched = [&](SearchScheme scheme, bool align) {
    DisparityParams params = disparityParams();
    params.search.scheme = scheme;
    params.row_alignment.enabled = align;
    DisparityLoop pipeline(disparityAlone(params));
    run(pipeline, frame);
    int stages = 0;
    for (const StageTime& stage : pipeline.times())
      stages += stage.name == std::string("half-resolution match");
    return stages > 0;
  };
  EXPECT_FALSE(isMatched(SearchScheme::kPaper, false));
  EXPECT_FALSE(isMatched(SearchScheme::kFull, false));
  EXPECT_TRUE(isMatched(SearchScheme::kPaper, true));
  EXPECT_TRUE(isMatched(SearchScheme::kPredictive, false));
}

// The pipeline must use the motion that starts from the past frame.
class EgoMotionLink : public Loop {
 protected:
  /// Processes the next frame with an ego-motion of this state, from `frames` frames back.
  void next(PoseState state, int frames = 1) {
    const StreetFrame frame = street_.render(number_);
    EgoMotionEstimate estimate;
    estimate.state = state;
    estimate.frames = frames;
    if (state == PoseState::kKnown)
      estimate.motion = trueMotion(shown_.at(shown_.size() - frames), frame);
    const StereoFrame now = stereoFrame(frame, street_.rig(), number_++);
    const auto sequence = pipeline_.begin(now);
    if (sequence.verdict == SequenceGuard::Verdict::kBackward) path_.reset();
    if (sequence.verdict != SequenceGuard::Verdict::kContinues) path_.breakOff();
    path_.add(estimate, now.stamp);
    pipeline_.process(
        [&] {
          return OdometryOutput{estimate, path_.motionStart(), path_.pose()};
        },
        output_);
    shown_.push_back(frame);
  }
  Stamp stampOf(int number) const { return number * std::chrono::milliseconds(100); }

  std::optional<Stamp> past() const { return pipeline_.disparity().past().stamp(); }

  static PipelineParams params() {
    PipelineParams params;
    params.disparity = disparityParams();
    return params;
  }
  Pipeline pipeline_{params()};
  PipelineOutput output_;
  const DisparityOutput& maps_ = output_.disparity;
  CameraPath path_;
  std::vector<StreetFrame> shown_;
};

TEST_F(EgoMotionLink, AMotionOverALostFrameLeadsFromThePast) {
  next(PoseState::kLost);
  next(PoseState::kKnown);
  next(PoseState::kHeld);
  EXPECT_EQ(output_.pose.state, PoseState::kHeld);
  EXPECT_FALSE(maps_.predicted);
  EXPECT_EQ(past(), stampOf(1)) << "the lost frame is no past";
  next(PoseState::kKnown, 2);
  EXPECT_EQ(output_.motion_start, stampOf(1));
  EXPECT_TRUE(maps_.predicted);
  EXPECT_EQ(past(), stampOf(3));
  EXPECT_LT(outliers(shown_.back(), maps_.disparity_px), 0.15);
}

TEST_F(EgoMotionLink, AMotionFromTheLostFrameIsNoneFromThePast) {
  next(PoseState::kLost);
  next(PoseState::kKnown);
  next(PoseState::kHeld);
  next(PoseState::kKnown, 1);
  EXPECT_EQ(output_.motion_start, stampOf(2));
  EXPECT_FALSE(maps_.predicted) << "it would miss the motion from frame 1 to 2";
  EXPECT_EQ(past(), stampOf(3)) << "frame 1 is out of reach for good";
  next(PoseState::kKnown);
  EXPECT_TRUE(maps_.predicted);
}

TEST_F(EgoMotionLink, NothingGoesOnOverAGapOrBackInTime) {
  next(PoseState::kLost);
  next(PoseState::kKnown);
  number_ += 11;  // more than max_gap
  next(PoseState::kKnown);
  EXPECT_FALSE(output_.motion_start) << "its start is forgotten";
  EXPECT_FALSE(maps_.predicted);
  EXPECT_EQ(past(), stampOf(13));
  number_ = 1;
  next(PoseState::kKnown);
  EXPECT_FALSE(maps_.predicted);
  EXPECT_TRUE(output_.pose.T_odom_cam.isApprox(Eigen::Isometry3d::Identity()))
      << "the pose starts anew";
  const StreetFrame frame = street_.render(1);
  EXPECT_FALSE(pipeline_.process(stereoFrame(frame, street_.rig(), 1), output_)) << "a duplicate";
}

TEST_F(Loop, RefusesImagesThatDoNotFitTheCalibration) {
  DisparityLoop pipeline(disparityAlone());
  const cv::Mat1b image(100, 200, uchar{0});
  try {
    pipeline.begin({image, image, street_.rig(), Stamp()});
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "left image is 200x100 but the calibration is for 496x160");
  }
}

TEST(DisparityLoopAtRest, VarianceStaysBoundedAndDisparityUnbiased) {
  // Six hundred frames are ten minutes at one frame per second; a few noise patterns alternate.
  const Street street(streetOf("standstill"));
  std::vector<StreetFrame> frames;
  for (int i = 0; i < 5; ++i) frames.push_back(street.render(i));
  DisparityLoop pipeline(disparityAlone());
  const auto motion = [](const Past&) {
    CameraMotion rest;
    rest.covariance = Matrix6d::Identity() * 1e-8;
    return rest;
  };
  DisparityOutput output;
  std::vector<double> bias, within_sigma;
  for (int i = 0; i < 600; ++i) {
    const StreetFrame& frame = frames[i % frames.size()];
    pipeline.process(stereoFrame(frame, street.rig(), i), motion, output);
    if (i != 5 && i != 599) continue;
    cv::Mat1f error = output.disparity_px - frame.disparity_px;
    const cv::Mat good = (cv::abs(error) < 1) & (frame.disparity_px > 0);
    bias.push_back(cv::mean(error, good)[0]);
    const cv::Mat is_within = (error.mul(error) <= output.disparity_variance_px2) & good;
    within_sigma.push_back(static_cast<double>(cv::countNonZero(is_within)) /
                           cv::countNonZero(good));
  }
  EXPECT_LT(std::abs(bias[1]), 0.1);
  EXPECT_LT(std::abs(bias[1] - bias[0]), 0.03);
  // A filter that counts the same error 600 times as news would become too sure.
  EXPECT_GT(within_sigma[1], within_sigma[0] - 0.03);
}

TEST(Pipeline, FollowsTheStreetEndToEnd) {
  const Street street(streetOf("straight"));
  PipelineParams params;
  params.disparity = disparityParams();
  Pipeline pipeline(params);
  PipelineOutput output;
  StreetFrame first, frame;
  double wrong = 0;
  for (int i = 0; i < kFrames; ++i) {
    frame = street.render(i);
    if (i == 0) first = frame;
    pipeline.process(stereoFrame(frame, street.rig(), i), output);
    wrong = outliers(frame, output.disparity.disparity_px);
    EXPECT_EQ(output.disparity.predicted, i > 0);
  }
  const Eigen::Isometry3d T_first_cam = first.T_world_cam.inverse() * frame.T_world_cam;
  const double distance_m = T_first_cam.translation().norm();
  EXPECT_GT(distance_m, 1.0);
  EXPECT_LT((output.pose.T_odom_cam.translation() - T_first_cam.translation()).norm(),
            0.05 * distance_m);
  EXPECT_LT(wrong, 0.15);
  EXPECT_EQ(output.detections.mask.size(), frame.left.size());
}

}  // namespace
}  // namespace predictive_stereo
