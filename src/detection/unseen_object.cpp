#include "detection/unseen_object.h"

#include <algorithm>
#include <cmath>

namespace predictive_stereo {
namespace {

constexpr double kTolerance_m = 0.5,
                 kTolerance_px = 1;  // before its nearest, behind its farthest part
constexpr int kFewest_px = 60;
constexpr double kLeastShare = 0.6, kLeastMatched = 0.4;

}  // namespace

bool isStillThere(const StereoRig& rig, const DisparityRange& range, const cv::Mat1f& disparity_px,
                  const Observation& moved_along, cv::Mat1b& mask) {
  const cv::Rect box = moved_along.box_px & cv::Rect(cv::Point(), rig.size);
  if (box.area() < kFewest_px || !(moved_along.distance_m > 2 * kTolerance_m)) return false;
  const auto disparityAt = [&](double depth_m) {
    return static_cast<float>(rig.disparityTimesDepth() / depth_m);
  };
  const double nearest_m = moved_along.distance_m;
  const float nearest_px = disparityAt(nearest_m - kTolerance_m) + kTolerance_px;
  const float farthest_px =
      disparityAt(nearest_m + moved_along.size_m.z() + kTolerance_m) - kTolerance_px;
  mask.create(box.size());
  int matched = 0, inside = 0;
  for (int y = 0; y < box.height; ++y) {
    const float* const disparity = disparity_px[box.y + y] + box.x;
    uchar* const of_row = mask[y];
    for (int x = 0; x < box.width; ++x) {
      const bool is_matched = range.isValid(disparity[x]);
      const bool is_inside =
          is_matched && disparity[x] >= farthest_px && disparity[x] <= nearest_px;
      of_row[x] = is_inside ? 255 : 0;
      matched += is_matched;
      inside += is_inside;
    }
  }
  return inside >= kFewest_px && matched >= kLeastMatched * box.area() &&
         inside >= kLeastShare * matched;
}

}  // namespace predictive_stereo
