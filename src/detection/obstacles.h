/// Obstacles: depth-connected surfaces above the ground.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "detection/depth_cells.h"
#include "detection/ground_plane.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

/// Obstacles of one frame, as sets of cells.
class Obstacles {
 public:
  /// Its cells, row by row. Valid as long as the obstacles are.
  class Cells {
   public:
    constexpr Cells(const cv::Point* first, const cv::Point* last) : first_(first), last_(last) {}
    const cv::Point* begin() const { return first_; }
    const cv::Point* end() const { return last_; }
    int size() const { return static_cast<int>(last_ - first_); }
    /// The smallest box around them.
    cv::Rect area() const;

   private:
    const cv::Point *first_, *last_;
  };

  Obstacles() : ends_{0} {}
  /// @param number  of each cell's obstacle, from 0 on; -1: none.
  Obstacles(cv::Mat1i number, const std::vector<int>& sizes);
  int size() const { return static_cast<int>(ends_.size()) - 1; }
  Cells operator[](int k) const {
    const auto i = static_cast<size_t>(k);
    return {cells_.data() + ends_[i], cells_.data() + ends_[i + 1]};
  }
  const cv::Mat1i& number() const { return number_; }

 private:
  cv::Mat1i number_;
  std::vector<int> ends_;         // of each obstacle's cells; the first one is 0
  std::vector<cv::Point> cells_;  // of all obstacles, one after the other
};

/// Joins neighbouring cells if there is certainly no step in depth between them, over gaps of one
/// unknown cell.
/// Cells with a disparity that the rig measures at more than 60 m are left out.
/// @param ground  cells on it, up to kGroundMargin_m above, are left out; none: no cell is.
Obstacles findObstacles(const StereoRig& rig, const DepthCells& cells,
                        const std::optional<GroundPlane>& ground);

/// For each cell the width [px] of its obstacle at its thickest place: the largest square in it.
/// Large for cells of no obstacle, such as the ground. An obstacle ends where a farther surface
/// begins, not where a nearer one hides it.
cv::Mat1f obstacleWidths(const Obstacles& obstacles, const DepthCells& cells);

}  // namespace predictive_stereo
