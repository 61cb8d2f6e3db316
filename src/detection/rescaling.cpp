#include "detection/rescaling.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "imaging/half_image.h"
#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

constexpr double kPixels = 1242 * 375, kFocalLength_px = 900;

// For each of `rescaled_size` pixels that of `size` pixels in which its centre is.
std::vector<int> sources(int size, int rescaled_size) {
  std::vector<int> indices(static_cast<size_t>(rescaled_size));
  for (int i = 0; i < rescaled_size; ++i)
    indices[static_cast<size_t>(i)] = (2 * i + 1) * size / (2 * rescaled_size);
  return indices;
}

// - From 640x480 on, enlarging gains less than its time is worth; so does reducing by less than a
//   quarter.
// - A camera that sees a narrow part of the scene has few pixels, but large objects: it is not
//   enlarged beyond a focal length.
// - Twice: an enlarged image does not show smaller parts.
double scaleOf(const StereoRig& camera) {
  const double scale = std::sqrt(kPixels / camera.size.area());
  if (scale < 0.75) return scale;
  if (camera.size.area() >= 640 * 480) return 1;
  return std::clamp(kFocalLength_px / camera.fx_px, 1.0, std::min(scale, 2.0));
}

}  // namespace

Rescaling::Rescaling(const StereoRig& camera)
    : size_(camera.size), rescaled_size_(camera.size), focal_length_px_(camera.fx_px) {
  if (size_.empty()) return;
  const double scale = scaleOf(camera);
  if (scale == 1) return;
  rescaled_size_ = {std::max(1, cvRound(scale * size_.width)),
                    std::max(1, cvRound(scale * size_.height))};
  columns_ = sources(size_.width, rescaled_size_.width);
  rows_ = sources(size_.height, rescaled_size_.height);
  for (int width = size_.width; width >= 2 * rescaled_size_.width; width /= 2)
    halves_.emplace_back();
}

StereoRig Rescaling::of(const StereoRig& rig) const {
  if (isNone()) return rig;
  StereoRig rescaled = rig;
  rescaled.size = rescaled_size_;
  rescaled.fx_px *= scaleX();
  rescaled.fy_px *= scaleY();
  const auto centre = [](double px, double scale) { return scale * (px + 0.5) - 0.5; };
  rescaled.cx_left_px = centre(rig.cx_left_px, scaleX());
  rescaled.cx_right_px = centre(rig.cx_right_px, scaleX());
  rescaled.cy_px = centre(rig.cy_px, scaleY());
  return rescaled;
}

DisparityRange Rescaling::of(const DisparityRange& range) const {
  DisparityRange rescaled = range;
  rescaled.min_disparity = cvFloor(double{cameraPixel_px()} * range.min_disparity);
  return rescaled;
}

// OpenCV's interpolation over areas takes as long as the detector. The linear one skips pixels
// below half of the size.
void Rescaling::rescaleImage(const cv::Mat1b& image, cv::Mat1b& rescaled) {
  const cv::Mat1b* from = &image;
  for (cv::Mat1b& half : halves_) {
    halveImage(*from, half);
    from = &half;
  }
  cv::resize(*from, rescaled, rescaled_size_, 0, 0,
             scaleX() > 1 ? cv::INTER_CUBIC : cv::INTER_LINEAR);
}

void Rescaling::rescale(const DetectionInput& input, const DisparityRange& range,
                        DetectionInput& rescaled) {
  rescaled.stamp_s = input.stamp_s;
  rescaled.pose_state = input.pose_state;
  rescaled.T_odom_cam = input.T_odom_cam;
  rescaled.motion_covariance = input.motion_covariance;
  rescaled.rig = of(input.rig);
  rescaleImage(input.left, rescaled.left);
  rescaled.measured_disparity_px.create(rescaled_size_);
  rescaled.measured_variance_px2.create(rescaled_size_);
  const float scale = cameraPixel_px(), unknown = of(range).invalid();
  parallelForEach(rescaled_size_.height, [&](int y) {
    const int from_y = rows_[static_cast<size_t>(y)];
    const float *const disparity = input.measured_disparity_px[from_y],
                       *const variance = input.measured_variance_px2[from_y];
    float *const rescaled_disparity = rescaled.measured_disparity_px[y],
                 *const rescaled_variance = rescaled.measured_variance_px2[y];
    for (int x = 0; x < rescaled_size_.width; ++x) {
      const int from_x = columns_[static_cast<size_t>(x)];
      const float d = disparity[from_x];
      rescaled_disparity[x] = range.isValid(d) ? scale * d : unknown;
      rescaled_variance[x] = scale * scale * variance[from_x];
    }
  });
}

void Rescaling::restore(const Detections& rescaled, Detections& detections) const {
  const auto scale_x = static_cast<float>(scaleX()), scale_y = static_cast<float>(scaleY());
  detections.objects = rescaled.objects;
  for (DetectedObject& object : detections.objects) {
    cv::Rect2f& box = object.box_px;
    box = {box.x / scale_x, box.y / scale_y, box.width / scale_x, box.height / scale_y};
  }
  cv::resize(rescaled.mask, detections.mask, size_, 0, 0, cv::INTER_NEAREST);
}

}  // namespace predictive_stereo
