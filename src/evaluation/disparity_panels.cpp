#include "evaluation/disparity_panels.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "evaluation/disparity_metrics.h"
#include "predictive_stereo/residual.h"

namespace predictive_stereo {
namespace {

/// Values from 0 to `largest` as colours, black where `valid` is 0.
cv::Mat3b coloured(const cv::Mat& values, double largest, const cv::Mat1b& valid) {
  cv::Mat1b bytes;
  values.convertTo(bytes, CV_8U, 255 / largest);
  cv::Mat3b colours;
  cv::applyColorMap(bytes, colours, cv::COLORMAP_JET);
  colours.setTo(cv::Vec3b(0, 0, 0), ~valid);
  return colours;
}

/// Errors on pixels with truth: green to yellow up to 3 px, red for outliers, magenta without a
/// disparity; over the darkened image.
cv::Mat3b errorMap(const SequenceFrame& frame, const DisparityRange& range,
                   const cv::Mat1f& disparity_px) {
  cv::Mat3b map;
  cv::cvtColor(frame.left / 2, map, cv::COLOR_GRAY2BGR);
  const bool sparse =
      cv::countNonZero(frame.truth_px >= 0) < static_cast<int>(frame.truth_px.total() / 4);
  for (int y = 0; y < map.rows; ++y)
    for (int x = 0; x < map.cols; ++x) {
      const float truth_px = frame.truth_px(y, x);
      if (!hasTruth(truth_px)) continue;
      const float error_px = std::abs(disparity_px(y, x) - truth_px);
      cv::Vec3b colour(0, 200, cv::saturate_cast<uchar>(255 * error_px / 3));
      if (!range.isValid(disparity_px(y, x)))
        colour = {255, 0, 255};
      else if (isOutlier(disparity_px(y, x), truth_px))
        colour = {0, 0, 255};
      map(y, x) = colour;
      if (sparse && x + 1 < map.cols && y + 1 < map.rows)  // single pixels are hard to see
        map(y, x + 1) = map(y + 1, x) = map(y + 1, x + 1) = colour;
    }
  return map;
}

/// The differences that the paper's detector sums, and the detected boxes.
cv::Mat3b differenceMap(const MethodOutput& output, const DisparityRange& range) {
  constexpr float kLargest_px = 5.0f;
  const cv::Mat1f &measured = output.maps.measured_disparity_px,
                  &predicted = output.maps.predicted_disparity_px;
  cv::Mat1f difference_px;
  absoluteDifference(measured, predicted, range, kLargest_px, difference_px);
  const cv::Mat1b known = (measured >= range.min_disparity) & (predicted >= range.min_disparity);
  cv::Mat3b map = coloured(difference_px, kLargest_px, known);
  for (const DetectedObject& object : output.objects)
    cv::rectangle(map, cv::Rect(object.box_px), {255, 255, 255}, 3);
  return map;
}

}  // namespace

std::vector<Panel> panelsOf(const SequenceFrame& frame, const std::string& title,
                            const std::string& method, bool first, const DisparityRange& range,
                            const MethodOutput& output) {
  const DisparityOutput& maps = output.maps;
  std::vector<Panel> panels;
  if (first) {
    cv::Mat3b left;
    cv::cvtColor(frame.left, left, cv::COLOR_GRAY2BGR);
    panels.push_back({title + ", left image", left});
  }
  double largest_px = 64;
  if (!frame.truth_px.empty()) cv::minMaxLoc(frame.truth_px, nullptr, &largest_px);
  largest_px = std::max(16.0, largest_px);
  const cv::Mat1b valid = maps.disparity_px >= range.min_disparity;
  panels.push_back({method + ": disparity, 0 (blue) to " + fixed(largest_px, 0) + " px (red)",
                    coloured(maps.disparity_px, largest_px, valid)});
  if (!frame.truth_px.empty())
    panels.push_back(
        {method + ": errors, green to yellow up to 3 px, red outliers, magenta invalid",
         errorMap(frame, range, maps.disparity_px)});
  if (!maps.disparity_variance_px2.empty()) {
    cv::Mat1f sigma_px;
    cv::sqrt(maps.disparity_variance_px2, sigma_px);
    panels.push_back(
        {method + ": standard deviation, 0 (blue) to 2 px (red)", coloured(sigma_px, 2.0, valid)});
    panels.push_back(
        {method + ": disparities searched, 0 (blue) to " + std::to_string(range.count) + " (red)",
         coloured(maps.search_width_px, range.count, cv::Mat1b(valid.size(), uchar{255}))});
  }
  if (maps.predicted)
    panels.push_back({method + ": |measured - predicted|, 0 (blue) to 5 px (red), black unknown; " +
                          "objects that were found",
                      differenceMap(output, range)});
  return panels;
}

}  // namespace predictive_stereo
