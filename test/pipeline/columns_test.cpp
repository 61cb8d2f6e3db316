/// A rig whose right camera was turned after the calibration: the pipeline estimates the column
/// offset and corrects its disparities.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <set>
#include <vector>

#include "evaluation/simulation/street.h"
#include "predictive_stereo/pipeline.h"

namespace predictive_stereo {
namespace {

constexpr int kFrames = 10;
constexpr int kShiftPx = 2;

class Columns : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    StreetParams params;
    params.scene = "turn";
    params.width = 621;
    params.height = 188;
    const Street street(params);
    rig_ = street.rig();
    for (int i = 0; i < kFrames; ++i) frames_.push_back(street.render(20 + i));
  }
  static void TearDownTestSuite() { frames_.clear(); }

  static StereoFrame frameOf(int i, int shift_px) {
    const StreetFrame& frame = frames_[static_cast<size_t>(i)];
    cv::Mat1b right;
    cv::copyMakeBorder(frame.right.colRange(0, rig_.size.width - shift_px), right, 0, 0, shift_px,
                       0, cv::BORDER_REPLICATE);
    return {frame.left, right, rig_, i * std::chrono::milliseconds(100)};
  }

  // Median error of the measured disparities [px].
  static double bias(int i, const cv::Mat1f& disparity_px) {
    const cv::Mat1f& truth = frames_[static_cast<size_t>(i)].disparity_px;
    std::vector<float> errors;
    for (int y = 0; y < truth.rows; ++y)
      for (int x = 0; x < truth.cols; ++x)
        if (truth(y, x) > 4 && disparity_px(y, x) >= 0)
          errors.push_back(disparity_px(y, x) - truth(y, x));
    std::nth_element(errors.begin(),
                     errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2), errors.end());
    return static_cast<double>(errors[errors.size() / 2]);
  }

  static PipelineParams params() {
    PipelineParams params;
    params.disparity.matcher.range.count = 64;
    return params;
  }

  static std::vector<StreetFrame> frames_;
  static StereoRig rig_;
  PipelineOutput output_;
};

std::vector<StreetFrame> Columns::frames_;
StereoRig Columns::rig_;

TEST_F(Columns, DisparitiesAreCorrectedFromWhenTheOffsetIsKnown) {
  Pipeline pipeline(params());
  int steps = 0;
  double correction_px = 0;
  for (int i = 0; i < kFrames; ++i) {
    ASSERT_TRUE(pipeline.process(frameOf(i, kShiftPx), output_));
    const double step_px = output_.column_offset.correction_px - correction_px;
    correction_px = output_.column_offset.correction_px;
    steps += step_px != 0;
    EXPECT_NEAR(bias(i, output_.disparity.measured_disparity_px), correction_px - kShiftPx, 0.15)
        << i;
    // The past is kept, with the same correction.
    EXPECT_EQ(output_.disparity.predicted, i > 0) << i;
    if (i == 0) continue;
    EXPECT_NEAR(bias(i, output_.disparity.predicted_disparity_px), correction_px - kShiftPx, 0.2)
        << i;
  }
  EXPECT_EQ(steps, 1);
  EXPECT_NEAR(correction_px, kShiftPx, 0.15);
}

// The detector keeps its memory, with disparities changed by the step. What it reports for the
// first time after the step does not count.
TEST_F(Columns, ObjectsAreFollowedOverTheStep) {
  Pipeline shifted(params()), right(params());
  PipelineOutput of_right;
  std::set<int> before, of_right_before;
  int since_step = 0, of_right_since = 0;
  const auto add = [](const Detections& detections, std::set<int>& ids) {
    for (const DetectedObject& object : detections.objects) ids.insert(object.id);
  };
  const auto countKnown = [](const Detections& detections, const std::set<int>& ids) {
    int known = 0;
    for (const DetectedObject& object : detections.objects)
      known += static_cast<int>(ids.count(object.id));
    return known;
  };
  for (int i = 0; i < kFrames; ++i) {
    ASSERT_TRUE(shifted.process(frameOf(i, kShiftPx), output_));
    ASSERT_TRUE(right.process(frameOf(i, 0), of_right));
    if (output_.column_offset.correction_px == 0) {
      add(output_.detections, before);
      add(of_right.detections, of_right_before);
      continue;
    }
    since_step += countKnown(output_.detections, before);
    of_right_since += countKnown(of_right.detections, of_right_before);
  }
  EXPECT_FALSE(before.empty());
  EXPECT_GE(since_step, of_right_since - 1);
  EXPECT_LE(since_step, of_right_since + 1);
  EXPECT_GT(of_right_since, 2);
}

TEST_F(Columns, NothingChangesWhereTheRigIsRight) {
  PipelineParams without = params();
  without.disparity.correct_columns = false;
  Pipeline corrected(params()), plain(without);
  PipelineOutput plain_output;
  for (int i = 0; i < kFrames; ++i) {
    ASSERT_TRUE(corrected.process(frameOf(i, 0), output_));
    ASSERT_TRUE(plain.process(frameOf(i, 0), plain_output));
    EXPECT_EQ(output_.column_offset.correction_px, 0);
    EXPECT_EQ(
        cv::norm(output_.disparity.disparity_px, plain_output.disparity.disparity_px, cv::NORM_INF),
        0);
  }
  EXPECT_TRUE(output_.column_offset.known);
}

TEST_F(Columns, NothingIsCorrectedWhereItIsSwitchedOff) {
  PipelineParams without = params();
  without.disparity.correct_columns = false;
  Pipeline pipeline(without);
  for (int i = 0; i < kFrames; ++i) {
    ASSERT_TRUE(pipeline.process(frameOf(i, kShiftPx), output_));
    EXPECT_EQ(output_.column_offset.correction_px, 0);
    EXPECT_EQ(output_.disparity.predicted, i > 0);
  }
  EXPECT_NEAR(output_.column_offset.offset_px, kShiftPx, 0.15);
}

// As in the nodelets, where the ego-motion runs in another nodelet.
TEST_F(Columns, ACorrectionFromElsewhereIsUsed) {
  DisparityLoop loop(params().disparity, params().max_gap);
  ColumnOffset told;
  told.correction_px = kShiftPx;
  const StereoFrame frame = frameOf(0, kShiftPx);
  loop.begin(frame);
  loop.setColumnOffset(told);
  loop.measure([](const Past&) { return std::nullopt; }, {}, output_.disparity);
  EXPECT_NEAR(bias(0, output_.disparity.measured_disparity_px), 0, 0.15);
  EXPECT_EQ(loop.columnOffset().correction_px, kShiftPx);
  EXPECT_EQ(loop.rig().cx_right_px, frame.rig.cx_right_px + kShiftPx);
}

TEST_F(Columns, AnotherCalibrationStartsWithoutACorrection) {
  Pipeline pipeline(params());
  for (int i = 0; i < kFrames; ++i) ASSERT_TRUE(pipeline.process(frameOf(i, kShiftPx), output_));
  ASSERT_NE(output_.column_offset.correction_px, 0);
  StereoFrame frame = frameOf(0, kShiftPx);
  frame.stamp = kFrames * std::chrono::milliseconds(100);
  frame.rig.cx_right_px += kShiftPx;  // the cure that the diagnostics recommend
  ASSERT_TRUE(pipeline.process(frame, output_));
  EXPECT_EQ(output_.column_offset.correction_px, 0);
  EXPECT_NEAR(bias(0, output_.disparity.measured_disparity_px), 0, 0.15);
}

}  // namespace
}  // namespace predictive_stereo
