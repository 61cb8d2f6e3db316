/// Lists of primitives by tile of a plane.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <opencv2/core/types.hpp>
#include <utility>
#include <vector>

namespace predictive_stereo::simulation {

/// For each tile of a rectangle, the indices whose bounds overlap it, in the order of adding.
class Tiles {
 public:
  struct List {
    const int* first;
    const int* last;
    const int* begin() const { return first; }
    const int* end() const { return last; }
  };

  Tiles(cv::Rect2f area, float tile_size)
      : area_(area),
        per_tile_(1 / tile_size),
        columns_(static_cast<int>(std::ceil(area.width / tile_size))),
        rows_(static_cast<int>(std::ceil(area.height / tile_size))) {}

  /// @param bounds  of each index; those that lie outside of the area are left out.
  /// @param order  indices, in the order that each tile's list shall have.
  void fill(const std::vector<cv::Rect2f>& bounds, const std::vector<int>& order) {
    start_.assign(static_cast<size_t>(columns_ * rows_) + 1, 0);
    // Count, then place: one block of memory for all lists.
    for (const int index : order)
      overTiles(bounds[static_cast<size_t>(index)], [&](size_t tile) { ++start_[tile + 1]; });
    for (size_t i = 1; i < start_.size(); ++i) start_[i] += start_[i - 1];
    indices_.resize(start_.back());
    std::vector<size_t> next(start_.begin(), start_.end() - 1);
    for (const int index : order)
      overTiles(bounds[static_cast<size_t>(index)],
                [&](size_t tile) { indices_[next[tile]++] = index; });
  }

  /// The list at a point; points outside of the area have that of the nearest tile.
  List at(float x, float y) const {
    const size_t tile =
        static_cast<size_t>(tileOf(y - area_.y, rows_)) * static_cast<size_t>(columns_) +
        static_cast<size_t>(tileOf(x - area_.x, columns_));
    return {indices_.data() + start_[tile], indices_.data() + start_[tile + 1]};
  }

 private:
  int tileOf(float offset, int count) const {
    const float tile = offset * per_tile_;
    return tile <= 0 ? 0 : tile >= static_cast<float>(count) ? count - 1 : static_cast<int>(tile);
  }
  template <class Function>
  void overTiles(const cv::Rect2f& b, Function&& function) const {
    const float x = b.x - area_.x, y = b.y - area_.y;
    if (b.width <= 0 || x > area_.width || y > area_.height || x + b.width < 0 || y + b.height < 0)
      return;
    const int x1 = tileOf(x + b.width, columns_), y1 = tileOf(y + b.height, rows_);
    for (int row = tileOf(y, rows_); row <= y1; ++row)
      for (int column = tileOf(x, columns_); column <= x1; ++column)
        function(static_cast<size_t>(row) * static_cast<size_t>(columns_) +
                 static_cast<size_t>(column));
  }

  cv::Rect2f area_;
  float per_tile_;
  int columns_, rows_;
  std::vector<size_t> start_;  // of each tile's list in indices_
  std::vector<int> indices_;
};

}  // namespace predictive_stereo::simulation
