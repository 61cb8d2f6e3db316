#include "detection/overlay.h"

#include <cstdio>
#include <opencv2/imgproc.hpp>

namespace predictive_stereo {
namespace {

// The same colour for an id in every frame; neighbouring ids differ well.
cv::Scalar colourOf(int id) {
  const auto hue = static_cast<uchar>((static_cast<unsigned>(id) * 67u) % 180u);
  cv::Mat3b pixel(1, 1, cv::Vec3b(hue, 220, 255));
  cv::cvtColor(pixel, pixel, cv::COLOR_HSV2BGR);
  return {double(pixel(0)[0]), double(pixel(0)[1]), double(pixel(0)[2])};
}

}  // namespace

void drawMovingObjects(const cv::Mat1b& left, const Detections& detections, cv::Mat3b& overlay) {
  cv::cvtColor(left, overlay, cv::COLOR_GRAY2BGR);
  for (int y = 0; y < overlay.rows; ++y)
    for (int x = 0; x < overlay.cols; ++x)
      if (detections.mask(y, x)) overlay(y, x)[2] = cv::saturate_cast<uchar>(overlay(y, x)[2] + 90);
  for (const DetectedObject& object : detections.objects) {
    const cv::Scalar colour = colourOf(object.id);
    cv::rectangle(overlay, cv::Rect(object.box_px), colour, 2);
    char text[64];
    std::snprintf(text, sizeof text, "%d: %.0f m, %.1f m/s", object.id, object.distance_m,
                  object.velocity_mps.norm());
    const cv::Point at(int(object.box_px.x), std::max(12, int(object.box_px.y) - 4));
    cv::putText(overlay, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.45, {0, 0, 0}, 3, cv::LINE_AA);
    cv::putText(overlay, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.45, colour, 1, cv::LINE_AA);
  }
}

}  // namespace predictive_stereo
