#pragma once

#include <algorithm>
#include <opencv2/core.hpp>
#include <vector>

#include "odometry/corner_kernel.h"

namespace predictive_stereo {

/// Finds FAST corners that are spread evenly: the strongest ones in every cell of a grid, with a
/// minimum distance of a few pixels.
class CornerDetector {
 public:
  /// @param count  number of corners wanted, `taken` included.
  /// @param taken  existing points: their cells get fewer new ones.
  /// @param border_px  margin of the image without corners.
  /// @param corners  the new corners are appended here.
  void detect(const cv::Mat1b& image, int count, const std::vector<cv::Point2f>& taken,
              int border_px, std::vector<cv::Point2f>& corners);

 private:
  struct Cell {
    int vacant = 0;
    std::vector<cv::Point2f> taken;
  };
  struct Grid {
    Grid(const cv::Rect& image_area, int count);
    int column(float x) const {
      return std::clamp(static_cast<int>((x - area.x) * columns / area.width), 0, columns - 1);
    }
    int row(float y) const {
      return std::clamp(static_cast<int>((y - area.y) * rows / area.height), 0, rows - 1);
    }
    cv::Rect strip(int row) const;  ///< the pixels of a row of cells

    cv::Rect area;
    int columns, rows;
  };

  void fillRow(const cv::Mat1b& image, const Grid& grid, int row, FastCorners& fast,
               std::vector<cv::Point2f>& found);

  std::vector<Cell> cells_;
};

}  // namespace predictive_stereo
