/// The whole pipeline with all images and maps beside a guard page (guarded_memory.h): it does not
/// access memory beyond them, and its results are the same.
#include <gtest/gtest.h>

#include <vector>

#include "evaluation/simulation/street.h"
#include "guarded_memory.h"
#include "predictive_stereo/pipeline.h"

namespace predictive_stereo {
namespace {

using testing::Guard;
using testing::GuardEveryMat;

constexpr int kFrames = 8;

// Image sizes that are odd at every pyramid level.
StreetParams nearTraffic() {
  StreetParams params;
  params.scene = "near_half_moves";
  params.width = 435;
  params.height = 147;
  return params;
}

struct Outputs {
  std::vector<cv::Mat> maps;
  std::vector<double> numbers;
};

Outputs outputsOf(const StereoRig& rig, const std::vector<StreetFrame>& frames) {
  PipelineParams params;
  params.disparity.matcher.range.count = 64;
  Pipeline pipeline(params);
  PipelineOutput output;
  Outputs all;
  for (const StreetFrame& frame : frames) {
    pipeline.process(
        {frame.left.clone(), frame.right.clone(), rig, stampFromSeconds(frame.stamp_s)}, output);
    for (const cv::Mat& map :
         {cv::Mat(output.disparity.disparity_px), cv::Mat(output.disparity.disparity_variance_px2),
          cv::Mat(output.detections.mask)})
      all.maps.push_back(map.clone());
    for (int i = 0; i < 12; ++i)
      all.numbers.push_back(output.pose.T_odom_cam.matrix()(i / 4, i % 4));
    all.numbers.push_back(static_cast<double>(output.detections.objects.size()));
  }
  return all;
}

TEST(BorderReads, OfThePipeline) {
  const Street street(nearTraffic());
  std::vector<StreetFrame> frames;
  for (int k = 0; k < kFrames; ++k) frames.push_back(street.render(20 + k));
  const Outputs expected = outputsOf(street.rig(), frames);
  EXPECT_GT(cv::countNonZero(expected.maps.back()), 0) << "something moves";
  for (const Guard guard : {Guard::kBehind, Guard::kBefore}) {
    const GuardEveryMat guards(guard);
    const Outputs outputs = outputsOf(street.rig(), frames);
    EXPECT_EQ(outputs.numbers, expected.numbers);
    for (size_t i = 0; i < expected.maps.size(); ++i)
      EXPECT_EQ(cv::norm(outputs.maps[i], expected.maps[i], cv::NORM_INF), 0) << i;
  }
}

}  // namespace
}  // namespace predictive_stereo
