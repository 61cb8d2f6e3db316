#include "predictive_stereo/detectable_speed.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "detection/constants.h"
#include "detection/motion_noise.h"
#include "detection/point_tracks.h"
#include "detection/rescaling.h"

namespace predictive_stereo {
namespace {

void requirePositive(const char* name, double value) {
  if (!(value > 0 && std::isfinite(value)))
    throw std::invalid_argument(std::string(name) + " = " + std::to_string(value) +
                                ": must be positive and finite");
}

}  // namespace

DetectableSpeed detectableSpeed(const StereoRig& rig, double depth_m, double frame_interval_s,
                                const MotionDetectionParams& detection,
                                const VarianceParams& variance) {
  requirePositive("depth_m", depth_m);
  requirePositive("frame_interval_s", frame_interval_s);
  const StereoRig rescaled = Rescaling(rig).of(rig);
  const double fB = rescaled.disparityTimesDepth();
  const double disparity_px = fB / depth_m;
  const double sigmas = std::sqrt(detection.min_mahalanobis);

  // Both channels compare with the second of the past frames that are kept. If images are compared
  // with the previous frame, too, the first one is their oldest.
  const double frames_apart = std::ceil(kLeastApart_s / frame_interval_s);
  const double frames_along = 2 * frames_apart,
               frames_across = frames_apart == 2 ? 2 : frames_along;
  // The noise of the ego-motion adds up from frame to frame.
  const auto egoNoise_m = [&](double frames) {
    return std::sqrt(frames) * std::hypot(kUntoldMotionSigma_m, depth_m * kUntoldMotionSigma_rad);
  };
  const double ego_flow_px = rescaled.fx_px * egoNoise_m(frames_across) / depth_m;
  const double flow_px = sigmas * std::hypot(kFlowSigma_px, ego_flow_px);
  const double across_m = flow_px * depth_m / rescaled.fx_px;

  const double floor_px = variance.sigma_floor_px * rescaled.fx_px / rig.fx_px;
  const double match_px2 =
      std::max<double>(floor_px * floor_px, kDisparitySigma_px * kDisparitySigma_px);
  const double previous_px2 = double{kDisparitySigma_px} * kDisparitySigma_px;
  const double ego_px = disparity_px * egoNoise_m(frames_along) / depth_m;
  const double point_px = sigmas * std::sqrt(match_px2 + previous_px2 + ego_px * ego_px);
  const double change_px = std::min(point_px, detection.dense_min_residual_px);
  const double along_m = change_px < disparity_px ? fB / (disparity_px - change_px) - depth_m
                                                  : std::numeric_limits<double>::infinity();
  return {across_m / (frames_across * frame_interval_s),
          along_m / (frames_along * frame_interval_s)};
}

}  // namespace predictive_stereo
