/// A grid of item lists over a rectangle.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <opencv2/core/types.hpp>
#include <utility>
#include <vector>

namespace predictive_stereo::simulation {

/// For each tile of a rectangle, the items whose bounds overlap it, in the order of adding.
class Tiles {
 public:
  struct Item {
    float left, top, right, bottom;  ///< bounds; right < left: empty
    float nearest;                   ///< lower bound of its distance
    int index;

    bool covers(float x, float y) const {
      return x >= left && x <= right && y >= top && y <= bottom;
    }
  };
  struct List {
    const Item *first, *last;
    const Item* begin() const { return first; }
    const Item* end() const { return last; }
  };

  Tiles(cv::Rect2f area, float tile_size)
      : area_(area),
        per_tile_(1 / tile_size),
        columns_(static_cast<int>(std::ceil(area.width / tile_size))),
        rows_(static_cast<int>(std::ceil(area.height / tile_size))) {}

  /// @param items  in the order of each tile's list.
  void fill(const std::vector<Item>& items) {
    start_.assign(static_cast<size_t>(columns_ * rows_) + 1, 0);
    // Counting sort: the lists are contiguous in one block of memory.
    for (const Item& item : items) overTiles(item, [&](size_t tile) { ++start_[tile + 1]; });
    for (size_t i = 1; i < start_.size(); ++i) start_[i] += start_[i - 1];
    items_.resize(start_.back());
    std::vector<size_t> next(start_.begin(), start_.end() - 1);
    for (const Item& item : items)
      overTiles(item, [&](size_t tile) { items_[next[tile]++] = item; });
  }

  /// The list at a point. Points outside the area get that of the nearest tile.
  List at(float x, float y) const {
    const size_t tile =
        static_cast<size_t>(tileOf(y - area_.y, rows_)) * static_cast<size_t>(columns_) +
        static_cast<size_t>(tileOf(x - area_.x, columns_));
    return {items_.data() + start_[tile], items_.data() + start_[tile + 1]};
  }

 private:
  int tileOf(float offset, int count) const {
    const float tile = offset * per_tile_;
    return tile <= 0 ? 0 : tile >= static_cast<float>(count) ? count - 1 : static_cast<int>(tile);
  }
  template <class Function>
  void overTiles(const Item& item, Function&& function) const {
    const float left = item.left - area_.x, right = item.right - area_.x;
    const float top = item.top - area_.y, bottom = item.bottom - area_.y;
    if (right < left || left > area_.width || top > area_.height || right < 0 || bottom < 0) return;
    const int last_column = tileOf(right, columns_), last_row = tileOf(bottom, rows_);
    for (int row = tileOf(top, rows_); row <= last_row; ++row)
      for (int column = tileOf(left, columns_); column <= last_column; ++column)
        function(static_cast<size_t>(row) * static_cast<size_t>(columns_) +
                 static_cast<size_t>(column));
  }

  cv::Rect2f area_;
  float per_tile_;
  int columns_, rows_;
  std::vector<size_t> start_;  // of each tile's list in items_
  std::vector<Item> items_;
};

}  // namespace predictive_stereo::simulation
