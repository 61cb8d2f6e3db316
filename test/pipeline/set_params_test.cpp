/// Parameters that change between two frames: what is known of the past stays.
#include <gtest/gtest.h>

#include <vector>

#include "predictive_stereo/pipeline.h"
#include "simulation/street.h"

namespace predictive_stereo {
namespace {

constexpr int kFrames = 6, kChange = 3;

/// The stages one by one, as the nodelets run them.
struct Stages {
  explicit Stages(const PipelineParams& p)
      : ego_motion(p.ego_motion), disparity(p.disparity), detector(p.detection) {}

  void setParams(const PipelineParams& p) {
    ego_motion.setParams(p.ego_motion);
    disparity.setParams(p.disparity);
    detector.setParams(p.detection);
  }

  void process(const StreetFrame& frame, const StereoRig& rig, double stamp_s) {
    estimate = ego_motion.estimate(frame.left, frame.right, rig);
    T_odom_cam = T_odom_cam * estimate.motion.T_cam_prev.inverse();
    disparity.prepare(frame.left, frame.right, rig);
    const bool tracked = estimate.status == EgoMotionStatus::kTracked && estimate.frames == 1;
    disparity.estimate(tracked ? std::optional(estimate.motion) : std::nullopt, output);
    detector.detect(
        {stamp_s, rig, frame.left, output.measured_disparity_px, output.measured_variance_px2,
         output.predicted_disparity_px, output.predicted_variance_px2, true, T_odom_cam},
        detections);
  }

  EgoMotion ego_motion;
  DisparityEstimator disparity;
  MovingObjectDetector detector;
  Eigen::Isometry3d T_odom_cam = Eigen::Isometry3d::Identity();
  EgoMotionEstimate estimate;
  DisparityOutput output;
  Detections detections;
};

class SetParams : public testing::Test {
 protected:
  SetParams() : street_(streetParams()) {
    params_.disparity.matcher.range.count = params_.detection.range.count = 64;
    for (int i = 0; i < kFrames; ++i) frames_.push_back(street_.render(i));
  }

  static StreetParams streetParams() {
    StreetParams params;
    params.scene = "straight";
    params.width = 496;
    params.height = 160;
    params.frames = kFrames;
    return params;
  }

  /// @param changed  the parameters from frame kChange on.
  Stages run(const PipelineParams& changed, bool change) {
    Stages stages(params_);
    for (int i = 0; i < kFrames; ++i) {
      if (change && i == kChange) stages.setParams(changed);
      stages.process(frames_[i], street_.rig(), street_.stampOf(i));
    }
    return stages;
  }

  PipelineParams params_;
  Street street_;
  std::vector<StreetFrame> frames_;
};

void expectEqual(const cv::Mat& a, const cv::Mat& b, const char* name) {
  ASSERT_EQ(a.size(), b.size()) << name;
  EXPECT_EQ(cv::countNonZero(a != b), 0) << name;
}

TEST_F(SetParams, the_same_parameters_change_nothing) {
  const Stages plain = run(params_, false), set = run(params_, true);
  EXPECT_TRUE(set.T_odom_cam.isApprox(plain.T_odom_cam, 0));
  expectEqual(set.output.disparity_px, plain.output.disparity_px, "disparity");
  expectEqual(set.output.disparity_variance_px2, plain.output.disparity_variance_px2, "variance");
  expectEqual(set.output.predicted_disparity_px, plain.output.predicted_disparity_px, "predicted");
  expectEqual(set.output.measured_disparity_px, plain.output.measured_disparity_px, "measured");
  expectEqual(set.output.predicted_variance_px2, plain.output.predicted_variance_px2,
              "predicted variance");
  EXPECT_EQ(set.detections.objects.size(), plain.detections.objects.size());
}

TEST_F(SetParams, other_parameters_hold_from_the_next_frame_on) {
  PipelineParams changed = params_;
  changed.disparity.search.scheme = SearchScheme::kFull;
  changed.ego_motion.features = 100;
  const Stages stages = run(changed, true);
  EXPECT_EQ(cv::countNonZero(stages.output.search_width_px != 64), 0);
  EXPECT_TRUE(stages.output.predicted) << "the past is lost";
  EXPECT_EQ(stages.estimate.status, EgoMotionStatus::kTracked);
}

TEST_F(SetParams, another_range_forgets_the_past) {
  PipelineParams changed = params_;
  changed.disparity.matcher.range.count = changed.detection.range.count = 48;
  Stages stages(params_);
  for (int i = 0; i < kFrames; ++i) {
    if (i == kChange) stages.setParams(changed);
    stages.process(frames_[i], street_.rig(), street_.stampOf(i));
    EXPECT_EQ(stages.output.predicted, i != 0 && i != kChange) << i;
  }
  EXPECT_EQ(cv::countNonZero(stages.output.disparity_px >= 48), 0);
}

TEST_F(SetParams, switching_the_disparity_offset_starts_it_anew) {
  PipelineParams changed = params_;
  changed.ego_motion.estimate_disparity_offset = !params_.ego_motion.estimate_disparity_offset;
  Stages stages(params_);
  for (int i = 0; i < kFrames; ++i) {
    if (i == kChange) stages.setParams(changed);
    stages.process(frames_[i], street_.rig(), street_.stampOf(i));
    EXPECT_EQ(stages.estimate.status,
              i == 0 || i == kChange ? EgoMotionStatus::kFirstFrame : EgoMotionStatus::kTracked)
        << i;
  }
}

TEST_F(SetParams, what_is_refused_changes_nothing) {
  Stages stages(params_);
  for (int i = 0; i < kFrames; ++i) {
    if (i == kChange) {
      PipelineParams bad = params_;
      bad.disparity.matcher.p1 = bad.disparity.matcher.p2;
      bad.disparity.min_support = 3;
      bad.ego_motion.features = 0;
      bad.detection.paper.largest_window_width_px = 1;
      EXPECT_THROW(stages.disparity.setParams(bad.disparity), std::invalid_argument);
      EXPECT_THROW(stages.ego_motion.setParams(bad.ego_motion), std::invalid_argument);
      EXPECT_THROW(stages.detector.setParams(bad.detection), std::invalid_argument);
    }
    stages.process(frames_[i], street_.rig(), street_.stampOf(i));
  }
  const Stages plain = run(params_, false);
  EXPECT_TRUE(stages.T_odom_cam.isApprox(plain.T_odom_cam, 0));
  expectEqual(stages.output.disparity_px, plain.output.disparity_px, "disparity");
  expectEqual(stages.output.measured_disparity_px, plain.output.measured_disparity_px, "measured");
  expectEqual(stages.output.predicted_variance_px2, plain.output.predicted_variance_px2,
              "predicted variance");
}

}  // namespace
}  // namespace predictive_stereo
