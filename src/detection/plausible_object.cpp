#include "detection/plausible_object.h"

#include <algorithm>

namespace predictive_stereo {
namespace {

constexpr double kSlope = 0.03;        // of the ground: a far object may be uphill
constexpr double kLeastVisible = 0.5;  // of the height of a partly hidden object

}  // namespace

double highestEnd_m(const MotionDetectionParams& params, bool is_hidden, double distance_m) {
  const double hidden_m = is_hidden ? (1 - kLeastVisible) * params.max_height_m : 0;
  return hidden_m + params.max_foot_m + kSlope * distance_m;
}

LowerEnd lowerEndOf(const StereoRig& rig, const DisparityRange& range,
                    const cv::Mat1f& disparity_px, const LevelGround& ground, const cv::Rect& box,
                    float layer_px, float nearest_px) {
  constexpr int kCutRows_px = 4;
  if (box.br().y >= rig.size.height - kCutRows_px) return LowerEnd::kCut;
  // Hidden: in many of its columns a nearer surface that is not ground is below it.
  constexpr double kBelow_m = 0.3;
  constexpr int kLeastBelow_px = 6;
  const int below =
      std::max(kLeastBelow_px, static_cast<int>(kBelow_m * layer_px / rig.baseline_m));
  const int end = std::min(box.br().y + below, rig.size.height - 1);
  int nearer = 0;
  for (int x = box.x / 2; x < box.br().x / 2; ++x)
    for (int y = (box.br().y + 1) / 2; y <= end / 2; ++y) {
      const float d = disparity_px(2 * y, 2 * x);
      if (!range.isValid(d) || d <= nearest_px || ground.isLevel({x, y})) continue;
      ++nearer;
      break;
    }
  return 4 * nearer > box.width ? LowerEnd::kHidden : LowerEnd::kFoot;
}

bool isPlausible(const StereoRig& rig, const MotionDetectionParams& params,
                 const std::optional<RoadLine>& road, const cv::Rect& box, double depth_m,
                 float layer_px, LowerEnd lower_end) {
  const double height_m = box.height * depth_m / rig.fy_px;
  const double width_m = box.width * depth_m / rig.fx_px;
  const double visible = lower_end == LowerEnd::kFoot     ? 1
                         : lower_end == LowerEnd::kHidden ? kLeastVisible
                                                          : 0;
  if (height_m < visible * params.min_height_m || height_m > params.max_height_m ||
      width_m < params.min_width_m || width_m > params.max_width_m)
    return false;
  if (!road || lower_end == LowerEnd::kCut) return true;
  const double end_m = road->heightOf(box.br().y, layer_px, rig.baseline_m);
  const double layer_m = rig.disparityTimesDepth() / layer_px;
  return !(end_m > highestEnd_m(params, lower_end == LowerEnd::kHidden, layer_m));
}

}  // namespace predictive_stereo
