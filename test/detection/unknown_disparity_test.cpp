/// Unknown disparities say nothing: with another smallest disparity their value is another one, and
/// the same objects are found.
#include <gtest/gtest.h>

#include <vector>

#include "detection/point_tracks.h"
#include "evaluation/simulation/street.h"
#include "predictive_stereo/moving_objects.h"

namespace predictive_stereo {
namespace {

constexpr int kFirst = 20, kFrames = 8;

const std::vector<StreetFrame>& frames() {
  static const std::vector<StreetFrame> frames = [] {
    const Street street{StreetParams()};
    std::vector<StreetFrame> rendered;
    for (int k = kFirst; k < kFirst + kFrames; ++k) rendered.push_back(street.render(k));
    return rendered;
  }();
  return frames;
}

/// What is found in the frames, as numbers.
/// @param nearest_unknown_px  all disparities below it are unknown, and spots of any disparity.
std::vector<double> found(const DisparityRange& range, int nearest_unknown_px) {
  DetectionParams params;
  params.range = range;
  MovingObjectDetector detector(params);
  DetectionInput input;
  input.rig = Street{StreetParams()}.rig();
  input.pose_state = PoseState::kKnown;
  input.measured_variance_px2 = cv::Mat1f(input.rig.size, 0.1f);
  input.predicted_disparity_px = cv::Mat1f(input.rig.size, range.invalid());
  input.predicted_variance_px2 = cv::Mat1f(input.rig.size, 0.0f);
  cv::RNG rng(5);
  std::vector<double> numbers;
  for (const StreetFrame& frame : frames()) {
    input.stamp_s = frame.stamp_s;
    input.left = frame.left;
    input.T_odom_cam = frame.T_world_cam;
    frame.disparity_px.copyTo(input.measured_disparity_px);
    input.measured_disparity_px.setTo(range.invalid(),
                                      frame.disparity_px < static_cast<double>(nearest_unknown_px));
    for (int i = 0; i < 3000; ++i) {
      const cv::Rect spot(rng.uniform(0, input.rig.size.width - 9),
                          rng.uniform(0, input.rig.size.height - 5), 9, 5);
      input.measured_disparity_px(spot) = range.invalid();
    }
    Detections detections;
    detector.detect(input, detections);
    for (const DetectedObject& o : detections.objects) {
      numbers.insert(numbers.end(), {double(o.id), o.box_px.x, o.box_px.y, o.box_px.width,
                                     o.box_px.height, o.score, double(o.age), o.distance_m});
      for (const Eigen::Vector3d& v : {o.centre_m, o.size_m, o.velocity_mps})
        numbers.insert(numbers.end(), v.data(), v.data() + 3);
    }
    numbers.push_back(cv::countNonZero(detections.mask));
  }
  return numbers;
}

TEST(UnknownDisparity, ItsValueDoesNotMatter) {
  for (const int smallest : {8, 12, 16}) {
    const std::vector<double> of_zero = found({0, 128}, smallest);
    EXPECT_GT(of_zero.size(), 2u * kFrames) << "something is found";
    EXPECT_EQ(found({smallest, 128}, smallest), of_zero) << "min_disparity " << smallest;
  }
}

TEST(UnknownDisparity, ShowsNoKnownObject) {
  const DisparityRange range{10, 64};
  DetectionInput input;
  input.rig = Street{StreetParams()}.rig();
  input.measured_disparity_px = cv::Mat1f(input.rig.size, range.invalid());
  const RememberedFrame current, before;
  const FrameView frame{input, range, {}, current, {}, {}, {}};
  ObjectTrack known;
  known.state.setZero();
  known.last.box_px = {600, 150, 80, 60};
  known.last.centre_m = {0, 0, input.rig.disparityTimesDepth() / 10};
  const PastFrame past{&before, Eigen::Isometry3d::Identity(), Matrix6d::Zero(), 0.1};
  EXPECT_FALSE(hypothesisOf(frame.since(past), known));
  input.measured_disparity_px.setTo(10);
  EXPECT_TRUE(hypothesisOf(frame.since(past), known));
}

}  // namespace
}  // namespace predictive_stereo
