#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace predictive_stereo {

struct PlotSeries {
  enum class Style { kLine, kMarkers, kSteps };
  std::string name;  ///< in the legend; empty: not in the legend
  std::vector<cv::Point2d>
      points;  ///< kSteps: (left end, height) of bars; the last point ends them
  Style style = Style::kLine;
};

/// A diagram with two axes.
struct Plot {
  std::string title, x_label, y_label;
  std::vector<PlotSeries> series;
  bool from_zero = true;    ///< the y axis begins at 0
  bool equal_axes = false;  ///< one unit has the same length in x and y, for maps
  cv::Size size{640, 400};  ///< [px]
};

/// The plot as an SVG element, for a file or an HTML page.
std::string svg(const Plot& plot);
/// The same as a picture.
cv::Mat3b picture(const Plot& plot);

}  // namespace predictive_stereo
