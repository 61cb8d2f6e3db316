#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace predictive_stereo {

/// Finds corners (FAST), spread evenly: in every cell of a grid the strongest ones, and no two
/// closer than a few pixels.
class CornerDetector {
 public:
  /// @param count  corners wanted in all, `taken` included.
  /// @param taken  points that exist already: their cells need fewer new ones.
  /// @param border_px  margin of the image without corners.
  /// @param corners  the new ones, appended.
  void detect(const cv::Mat1b& image, int count, const std::vector<cv::Point2f>& taken,
              int border_px, std::vector<cv::Point2f>& corners);

 private:
  struct Cell {
    int vacant = 0;
    std::vector<cv::Point2f> taken;
  };
  std::vector<Cell> cells_;
};

}  // namespace predictive_stereo
