/// FAST corners: pixels that are all darker, or all brighter, than nine successive ones of the
/// sixteen pixels on a circle around them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace predictive_stereo {

struct FastCorner {
  cv::Point position;
  int score;  ///< the largest threshold at which it is a corner
};

/// The corners of a part of an image after non-maximum suppression. The result is that of cv::FAST,
/// with a fifth of its instructions. Pixels less than 3 px from the image's border are no corners.
/// Keeps its buffers between calls.
class FastCorners {
 public:
  /// @param area  part of the image to search.
  /// @param least_score  0..254: the smallest score that append() can be called with.
  void find(const cv::Mat1b& image, const cv::Rect& area, int least_score);
  /// Appends the corners with a score of at least `least_score`, row by row.
  void append(int least_score, std::vector<FastCorner>& corners) const;

 private:
  cv::Rect area_;
  std::vector<uint8_t> peaks_;  // 1 + score at the corners of area_, 0 elsewhere
};

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
