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

/// A diagram with two axes, as data: scripts/report draws it.
struct Plot {
  std::string title, x_label, y_label;
  std::vector<PlotSeries> series;
  bool equal_axes = false;  ///< one unit has the same length in x and y, for maps
};

}  // namespace predictive_stereo
