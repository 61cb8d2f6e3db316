/// Some frames of any size and content through the whole core: tiny, odd, long, of one column; rigs
/// that no camera has; stamps in any order; parameters that change in between.
#include <cmath>
#include <opencv2/core/utility.hpp>

#include "bytes.h"
#include "predictive_stereo/pipeline.h"

using namespace predictive_stereo;

namespace {

cv::Size anySize(Bytes& bytes) {
  const int kind = bytes.byte() % 16;
  if (kind == 0) return {1, bytes.whole(1, 300)};
  if (kind == 1) return {bytes.whole(1, 300), 1};
  if (kind == 2) return {bytes.whole(1, 5000), bytes.whole(1, 4)};
  if (kind == 3) return {bytes.whole(1, 4), bytes.whole(1, 5000)};
  if (kind == 4) return {bytes.whole(0, 400), bytes.whole(0, 100)};
  return {bytes.whole(1, 90), bytes.whole(1, 40)};
}

// A scene of some texture that moves a little from frame to frame, seen by both cameras.
void paint(Bytes& bytes, cv::Size size, StereoFrame& frame) {
  frame.left.create(size);
  frame.right.create(size);
  const uint8_t kind = bytes.byte();
  const int disparity = bytes.byte() % 32, step = bytes.byte();
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const auto texture = [&](int u) {
        return static_cast<uchar>(kind % 4 == 0 ? 128 : (u + step) * 37 % 101 * (y + 3) * 53 % 251);
      };
      frame.left(y, x) = texture(x);
      frame.right(y, x) = kind % 4 == 1 ? static_cast<uchar>(x * y) : texture(x + disparity);
    }
  for (int i = 0; i < 256 && bytes.left() > 8 && kind & 128; ++i) {
    const int x = bytes.whole(0, 4999), y = bytes.whole(0, 4999);
    (i % 2 ? frame.left : frame.right)(y % size.height, x % size.width) = bytes.byte();
  }
}

StereoRig anyRig(Bytes& bytes, cv::Size size) {
  const bool usual = bytes.byte() % 4 != 0;
  const auto value = [&](double normal) { return usual ? normal : bytes.number(normal); };
  const double fx = value(100), fy = value(100), cx = value(size.width / 2.0),
               cy = value(size.height / 2.0);
  Matrix34d P_left, P_right;
  P_left << fx, 0, cx, value(0), 0, fy, cy, 0, 0, 0, 1, 0;
  P_right << fx, 0, value(cx), value(-50), 0, fy, cy, 0, 0, 0, 1, 0;
  return StereoRig::fromProjections(P_left, P_right, size);
}

PipelineParams anyParams(Bytes& bytes) {
  PipelineParams params;
  MatcherParams& matcher = params.disparity.matcher;
  matcher.range.min_disparity = bytes.whole(-8, 8);
  matcher.range.count = 16 * bytes.whole(1, 3);
  const uint8_t kinds = bytes.byte(), more = bytes.byte();
  matcher.census = static_cast<CensusForm>(kinds % 3);
  matcher.paths = static_cast<PathSet>(kinds / 3 % 3);
  params.disparity.search.scheme = static_cast<SearchScheme>(2 - kinds / 9 % 3);
  matcher.exact_ranges = kinds >= 250;
  params.disparity.min_region_px = more & 1 ? 0 : 20;
  params.disparity.max_hole_px = more & 2 ? 1000 : 10;
  params.disparity.min_support = more & 4 ? 0 : 10;
  params.disparity.use_moving_mask = !(more & 8);
  params.disparity.prediction.reject_near_edges = more & 16;
  return params;
}

void check(const PipelineOutput& output, const DisparityRange& range) {
  const DisparityOutput& maps = output.disparity;
  const auto checkMap = [&](const char* name, const cv::Mat1f& disparity,
                            const cv::Mat1f& variance) {
    for (int y = 0; y < disparity.rows; ++y)
      for (int x = 0; x < disparity.cols; ++x) {
        const float d = disparity(y, x), v = variance(y, x);
        if (!std::isfinite(d) || !std::isfinite(v) || v < 0 ||
            (d != range.invalid() && d < range.invalid()))
          finding(std::string(name) + " has " + std::to_string(d) + " px, " + std::to_string(v) +
                  " px^2 at " + std::to_string(x) + ", " + std::to_string(y));
      }
  };
  checkMap("disparity", maps.disparity_px, maps.disparity_variance_px2);
  checkMap("measured disparity", maps.measured_disparity_px, maps.measured_variance_px2);
  checkMap("predicted disparity", maps.predicted_disparity_px, maps.predicted_variance_px2);
  if (!output.pose.T_odom_cam.matrix().allFinite()) finding("a pose that is not finite");
  if (!output.pose.covariance.allFinite()) finding("a covariance that is not finite");
  for (const DetectedObject& object : output.detections.objects)
    if (!object.centre_m.allFinite() || !object.velocity_mps.allFinite() ||
        !std::isfinite(object.distance_m))
      finding("an object that is nowhere");
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  cv::setNumThreads(1);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  Bytes bytes(data, size);
  const PipelineParams params = anyParams(bytes);
  Pipeline pipeline(params);
  PipelineOutput output;
  cv::Size image = anySize(bytes);
  Stamp stamp(bytes.byte() % 4 ? 1000000000 : bytes.raw<int64_t>() / 2);
  const int frames = 1 + bytes.byte() % 4;
  for (int i = 0; i < frames; ++i) {
    mayRefuse([&] {
      StereoFrame frame;
      const uint8_t change = bytes.byte();
      if (change == 255) image = anySize(bytes);
      frame.rig = anyRig(bytes, image);
      paint(bytes, image, frame);
      if (change == 254) frame.right = frame.right.colRange(0, image.width / 2);
      stamp += change % 8 ? Stamp(100000000) : Stamp(bytes.raw<int32_t>());
      frame.stamp = stamp;
      if (change % 16 == 5) {
        DisparityParams other = params.disparity;
        other.matcher.range.min_disparity = bytes.whole(-8, 8);
        pipeline.setParams(other);
      }
      if (pipeline.process(frame, output))
        check(output, pipeline.disparity().params().matcher.range);
    });
  }
  return 0;
}
