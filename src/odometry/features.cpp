#include "odometry/features.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

constexpr int kPerCell = 3;
constexpr float kSmallestDistancePx = 8;
// Smallest scores, tried one after the other until a row of cells has enough corners: first strong
// corners only; dark images need the second.
constexpr std::array<int, 2> kScores = {20, 5};

constexpr auto strongerFirst = [](const FastCorner& a, const FastCorner& b) {
  if (a.score != b.score) return a.score > b.score;
  return a.position.y != b.position.y ? a.position.y < b.position.y : a.position.x < b.position.x;
};

bool farFromAll(cv::Point2f point, const std::vector<cv::Point2f>& others) {
  return std::none_of(others.begin(), others.end(), [&](cv::Point2f other) {
    const cv::Point2f d = point - other;
    return d.dot(d) < kSmallestDistancePx * kSmallestDistancePx;
  });
}

}  // namespace

CornerDetector::Grid::Grid(const cv::Rect& image_area, int count) : area(image_area) {
  // Half of the cells are on sky or road without texture: make room for twice the number.
  const double side = std::sqrt(static_cast<double>(area.area()) * kPerCell / (2.0 * count));
  columns = std::max(1, static_cast<int>(std::lround(area.width / side)));
  rows = std::max(1, static_cast<int>(std::lround(area.height / side)));
}

cv::Rect CornerDetector::Grid::strip(int row) const {
  const int top = area.y + (row * area.height + rows - 1) / rows;
  const int bottom = area.y + ((row + 1) * area.height + rows - 1) / rows;
  return {area.x, top, area.width, bottom - top};
}

void CornerDetector::detect(const cv::Mat1b& image, int count,
                            const std::vector<cv::Point2f>& taken, int border_px,
                            std::vector<cv::Point2f>& corners) {
  const cv::Rect area(border_px, border_px, image.cols - 2 * border_px, image.rows - 2 * border_px);
  if (area.width <= 0 || area.height <= 0) return;
  const Grid grid(area, count);
  cells_.resize(static_cast<size_t>(grid.columns) * grid.rows);
  for (Cell& cell : cells_) {
    cell.vacant = kPerCell;
    cell.taken.clear();
  }
  for (cv::Point2f point : taken) {
    Cell& cell = cells_[grid.row(point.y) * grid.columns + grid.column(point.x)];
    --cell.vacant;
    cell.taken.push_back(point);
  }

  // Work is distributed by strips of cells: the result does not depend on the number of threads.
  std::vector<std::vector<cv::Point2f>> found(grid.rows);
  parallelFor(cv::Range(0, grid.rows), [&](const cv::Range& range) {
    FastCorners fast;
    for (int row = range.start; row < range.end; ++row) fillRow(image, grid, row, fast, found[row]);
  });
  for (const auto& of_row : found) corners.insert(corners.end(), of_row.begin(), of_row.end());
}

void CornerDetector::fillRow(const cv::Mat1b& image, const Grid& grid, int row, FastCorners& fast,
                             std::vector<cv::Point2f>& found) {
  Cell* cells = &cells_[static_cast<size_t>(row) * grid.columns];
  int wanted = 0;
  for (int c = 0; c < grid.columns; ++c) wanted += std::max(0, cells[c].vacant);
  if (wanted == 0) return;
  const auto isWelcome = [&](const FastCorner& candidate) {
    const Cell& cell = cells[grid.column(candidate.position.x)];
    return cell.vacant > 0 && farFromAll(candidate.position, cell.taken);
  };
  fast.find(image, grid.strip(row), kScores.back());
  std::vector<FastCorner> candidates;
  for (int score : kScores) {
    candidates.clear();
    fast.append(score, candidates);
    candidates.erase(std::remove_if(candidates.begin(), candidates.end(), std::not_fn(isWelcome)),
                     candidates.end());
    std::sort(candidates.begin(), candidates.end(), strongerFirst);
    for (const FastCorner& candidate : candidates) {
      if (!isWelcome(candidate)) continue;
      const cv::Point2f point = candidate.position;
      Cell& cell = cells[grid.column(point.x)];
      --cell.vacant;
      --wanted;
      cell.taken.push_back(point);
      found.push_back(point);
    }
    if (3 * wanted < grid.columns * kPerCell) break;
  }
}

}  // namespace predictive_stereo
