/// The evaluation measures the same loop as that of the pipeline.
#include <gtest/gtest.h>

#include <vector>

#include "evaluation/disparity_evaluation.h"

namespace predictive_stereo {
namespace {

constexpr int kFrames = 10;

/// Renders each frame only once, because rendering is slower than the tests.
class RenderedStreet : public Sequence {
 public:
  RenderedStreet() : Sequence("street"), street_(streetSequence(params())) {
    rig_ = street_->rig();
    for (int index = 0; index < kFrames; ++index) frames_.push_back(street_->frame(index));
  }
  int frames() const override { return kFrames; }
  double stamp_s(int index) const override { return street_->stamp_s(index); }
  SequenceFrame frame(int index) const override { return frames_[static_cast<size_t>(index)]; }

 private:
  static StreetParams params() {
    StreetParams params;
    params.scene = "leader";
    params.frames = kFrames;
    return params;
  }

  std::unique_ptr<Sequence> street_;
  std::vector<SequenceFrame> frames_;
};

const Sequence& street() {
  static const RenderedStreet street;
  return street;
}

/// The disparities of each frame from the whole pipeline, and its share of moving pixels.
struct Shipped {
  explicit Shipped(const PipelineParams& params) {
    Pipeline pipeline(params);
    PipelineOutput output;
    for (int index = 0; index < kFrames; ++index) {
      pipeline.process(stereoFrame(street(), index, street().frame(index)), output);
      disparities_px.push_back(output.disparity.disparity_px.clone());
      moving_pixels += cv::countNonZero(output.detections.mask);
    }
  }
  std::vector<cv::Mat1f> disparities_px;
  int moving_pixels = 0;
};

std::vector<cv::Mat1f> evaluated(const PipelineParams& params) {
  std::vector<cv::Mat1f> disparities_px;
  std::vector<DisparityEvaluation> evaluations;
  const NamedMethod ours{"ours", [&] { return predictiveMethod(params); }};
  evaluateDisparity(
      street(), {ours}, params, kFrames,
      [&](const SequenceFrame&, int, size_t, const MethodOutput& output) {
        disparities_px.push_back(output.maps.disparity_px.clone());
      },
      evaluations);
  return disparities_px;
}

int differences(const std::vector<cv::Mat1f>& a, const std::vector<cv::Mat1f>& b) {
  EXPECT_EQ(a.size(), b.size());
  int count = 0;
  for (size_t i = 0; i < std::min(a.size(), b.size()); ++i) count += cv::countNonZero(a[i] != b[i]);
  return count;
}

TEST(ShippedLoop, IsWhatDisparitiesAreMeasuredOn) {
  const PipelineParams params;
  const Shipped shipped(params);
  EXPECT_GT(shipped.moving_pixels, 1000) << "the loop is of interest where something moves";
  EXPECT_EQ(differences(evaluated(params), shipped.disparities_px), 0);
}

TEST(ShippedLoop, ParametersOfTheDetectionReachWhatIsMeasured) {
  PipelineParams blind;
  blind.detection.motion.min_height_m = blind.detection.motion.max_height_m = 100;
  const Shipped shipped(blind);
  EXPECT_EQ(shipped.moving_pixels, 0);
  const std::vector<cv::Mat1f> measured = evaluated(blind);
  EXPECT_EQ(differences(measured, shipped.disparities_px), 0);
  EXPECT_GT(differences(measured, evaluated(PipelineParams())), 0);
}

}  // namespace
}  // namespace predictive_stereo
