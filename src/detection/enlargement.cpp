#include "detection/enlargement.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "detection/constants.h"
#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

// The index of the pixel, of `size`, in which the centre of each of the `enlarged_size` pixels is.
std::vector<int> sources(int size, int enlarged_size) {
  std::vector<int> indices(static_cast<size_t>(enlarged_size));
  for (int i = 0; i < enlarged_size; ++i)
    indices[static_cast<size_t>(i)] = (2 * i + 1) * size / (2 * enlarged_size);
  return indices;
}

}  // namespace

Enlargement::Enlargement(cv::Size size) : size_(size), enlarged_size_(size) {
  if (size.empty()) return;
  const double scale = std::min(std::sqrt(kEnoughPixels / size.area()), kMostEnlarged);
  if (scale < kLeastEnlarged) return;
  enlarged_size_ = {cvRound(scale * size.width), cvRound(scale * size.height)};
}

StereoRig Enlargement::of(const StereoRig& rig) const {
  if (isNone()) return rig;
  StereoRig enlarged = rig;
  enlarged.size = enlarged_size_;
  enlarged.fx_px *= scaleX();
  enlarged.fy_px *= scaleY();
  const auto centre = [](double px, double scale) { return scale * (px + 0.5) - 0.5; };
  enlarged.cx_left_px = centre(rig.cx_left_px, scaleX());
  enlarged.cx_right_px = centre(rig.cx_right_px, scaleX());
  enlarged.cy_px = centre(rig.cy_px, scaleY());
  return enlarged;
}

void Enlargement::enlarge(const DetectionInput& input, const DisparityRange& range,
                          DetectionInput& enlarged) const {
  enlarged.stamp_s = input.stamp_s;
  enlarged.pose_state = input.pose_state;
  enlarged.T_odom_cam = input.T_odom_cam;
  enlarged.motion_covariance = input.motion_covariance;
  enlarged.rig = of(input.rig);
  cv::resize(input.left, enlarged.left, enlarged_size_, 0, 0, cv::INTER_CUBIC);
  enlarged.measured_disparity_px.create(enlarged_size_);
  enlarged.measured_variance_px2.create(enlarged_size_);
  const std::vector<int> columns = sources(size_.width, enlarged_size_.width),
                         rows = sources(size_.height, enlarged_size_.height);
  const auto scale = static_cast<float>(scaleX()), least = static_cast<float>(range.min_disparity);
  parallelForEach(enlarged_size_.height, [&](int y) {
    const int from_y = rows[static_cast<size_t>(y)];
    const float *const disparity = input.measured_disparity_px[from_y],
                       *const variance = input.measured_variance_px2[from_y];
    float *const enlarged_disparity = enlarged.measured_disparity_px[y],
                 *const enlarged_variance = enlarged.measured_variance_px2[y];
    for (int x = 0; x < enlarged_size_.width; ++x) {
      const int from_x = columns[static_cast<size_t>(x)];
      const float d = disparity[from_x];
      enlarged_disparity[x] = range.isValid(d) ? std::max(scale * d, least) : range.invalid();
      enlarged_variance[x] = scale * scale * variance[from_x];
    }
  });
}

void Enlargement::reduce(Detections& detections) const {
  const auto scale_x = static_cast<float>(scaleX()), scale_y = static_cast<float>(scaleY());
  for (DetectedObject& object : detections.objects) {
    cv::Rect2f& box = object.box_px;
    box = {box.x / scale_x, box.y / scale_y, box.width / scale_x, box.height / scale_y};
  }
  cv::Mat1b mask;
  cv::resize(detections.mask, mask, size_, 0, 0, cv::INTER_NEAREST);
  detections.mask = mask;
}

}  // namespace predictive_stereo
