/// Parameters that change between two frames: the past is kept.
#include <gtest/gtest.h>

#include <vector>

#include "evaluation/simulation/street.h"
#include "predictive_stereo/pipeline.h"

namespace predictive_stereo {
namespace {

constexpr int kFrames = 6, kChange = 3;

/// A pipeline with its last output.
struct Driven {
  explicit Driven(const PipelineParams& p) : pipeline(p) {}

  void setParams(const PipelineParams& p) {
    pipeline.setParams(p.ego_motion);
    pipeline.setParams(p.disparity);
    pipeline.setParams(p.detection);
  }
  void process(const StreetFrame& frame, const StereoRig& rig, double stamp_s) {
    pipeline.process({frame.left, frame.right, rig, stampFromSeconds(stamp_s)}, output);
  }

  Pipeline pipeline;
  PipelineOutput output;
};

class SetParams : public testing::Test {
 protected:
  SetParams() : street_(streetParams()) {
    params_.disparity.matcher.range.count = 64;
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
  PipelineOutput run(const PipelineParams& changed, bool change) {
    Driven driven(params_);
    for (int i = 0; i < kFrames; ++i) {
      if (change && i == kChange) driven.setParams(changed);
      driven.process(frames_[i], street_.rig(), street_.stampOf(i));
    }
    return driven.output;
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
  const PipelineOutput plain = run(params_, false), set = run(params_, true);
  EXPECT_TRUE(set.pose.T_odom_cam.isApprox(plain.pose.T_odom_cam, 0));
  expectEqual(set.disparity.disparity_px, plain.disparity.disparity_px, "disparity");
  expectEqual(set.disparity.disparity_variance_px2, plain.disparity.disparity_variance_px2,
              "variance");
  expectEqual(set.disparity.predicted_disparity_px, plain.disparity.predicted_disparity_px,
              "predicted");
  expectEqual(set.disparity.measured_disparity_px, plain.disparity.measured_disparity_px,
              "measured");
  expectEqual(set.disparity.predicted_variance_px2, plain.disparity.predicted_variance_px2,
              "predicted variance");
  EXPECT_EQ(set.detections.objects.size(), plain.detections.objects.size());
}

TEST_F(SetParams, other_parameters_hold_from_the_next_frame_on) {
  PipelineParams changed = params_;
  changed.disparity.search.scheme = SearchScheme::kFull;
  changed.ego_motion.features = 100;
  const PipelineOutput output = run(changed, true);
  EXPECT_EQ(cv::countNonZero(output.disparity.search_width_px != 64), 0);
  EXPECT_TRUE(output.disparity.predicted) << "the past is lost";
  EXPECT_EQ(output.ego_motion.state, PoseState::kKnown);
}

TEST_F(SetParams, another_range_forgets_the_past) {
  PipelineParams changed = params_;
  changed.disparity.matcher.range.count = 48;
  Driven driven(params_);
  for (int i = 0; i < kFrames; ++i) {
    if (i == kChange) driven.setParams(changed);
    driven.process(frames_[i], street_.rig(), street_.stampOf(i));
    EXPECT_EQ(driven.output.disparity.predicted, i != 0 && i != kChange) << i;
  }
  EXPECT_EQ(cv::countNonZero(driven.output.disparity.disparity_px >= 48), 0);
}

TEST_F(SetParams, switching_the_disparity_offset_starts_it_anew) {
  PipelineParams changed = params_;
  changed.ego_motion.estimate_disparity_offset = !params_.ego_motion.estimate_disparity_offset;
  Driven driven(params_);
  for (int i = 0; i < kFrames; ++i) {
    if (i == kChange) driven.setParams(changed);
    driven.process(frames_[i], street_.rig(), street_.stampOf(i));
    EXPECT_EQ(driven.output.ego_motion.state,
              i == 0 || i == kChange ? PoseState::kLost : PoseState::kKnown)
        << i;
  }
}

TEST_F(SetParams, what_is_refused_changes_nothing) {
  Driven driven(params_);
  for (int i = 0; i < kFrames; ++i) {
    if (i == kChange) {
      PipelineParams bad = params_;
      bad.disparity.matcher.p1 = bad.disparity.matcher.p2;
      bad.disparity.min_support = 3;
      bad.ego_motion.features = 0;
      bad.detection.paper.largest_window_width_px = 1;
      EXPECT_THROW(driven.pipeline.setParams(bad.disparity), std::invalid_argument);
      EXPECT_THROW(driven.pipeline.setParams(bad.ego_motion), std::invalid_argument);
      EXPECT_THROW(driven.pipeline.setParams(bad.detection), std::invalid_argument);
    }
    driven.process(frames_[i], street_.rig(), street_.stampOf(i));
  }
  const PipelineOutput plain = run(params_, false);
  EXPECT_TRUE(driven.output.pose.T_odom_cam.isApprox(plain.pose.T_odom_cam, 0));
  expectEqual(driven.output.disparity.disparity_px, plain.disparity.disparity_px, "disparity");
  expectEqual(driven.output.disparity.measured_disparity_px, plain.disparity.measured_disparity_px,
              "measured");
  expectEqual(driven.output.disparity.predicted_variance_px2,
              plain.disparity.predicted_variance_px2, "predicted variance");
}

}  // namespace
}  // namespace predictive_stereo
