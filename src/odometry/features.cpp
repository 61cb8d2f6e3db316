#include "odometry/features.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "odometry/corner_kernel.h"
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

void CornerDetector::detect(const cv::Mat1b& image, int count,
                            const std::vector<cv::Point2f>& taken, int border_px,
                            std::vector<cv::Point2f>& corners) {
  const cv::Rect area(border_px, border_px, image.cols - 2 * border_px, image.rows - 2 * border_px);
  if (area.width <= 0 || area.height <= 0) return;
  // Half of the cells are on sky or road without texture: make room for twice the number.
  const double side = std::sqrt(static_cast<double>(area.area()) * kPerCell / (2.0 * count));
  const int columns = std::max(1, static_cast<int>(std::lround(area.width / side)));
  const int rows = std::max(1, static_cast<int>(std::lround(area.height / side)));
  const auto column = [&](float x) {
    return std::clamp(static_cast<int>((x - area.x) * columns / area.width), 0, columns - 1);
  };
  const auto row = [&](float y) {
    return std::clamp(static_cast<int>((y - area.y) * rows / area.height), 0, rows - 1);
  };

  cells_.resize(static_cast<size_t>(columns) * rows);
  for (Cell& cell : cells_) {
    cell.vacant = kPerCell;
    cell.taken.clear();
  }
  for (cv::Point2f point : taken) {
    Cell& cell = cells_[row(point.y) * columns + column(point.x)];
    --cell.vacant;
    cell.taken.push_back(point);
  }

  // Work is distributed by strips of cells: the result does not depend on the number of threads.
  std::vector<std::vector<cv::Point2f>> found(rows);
  parallelFor(cv::Range(0, rows), [&](const cv::Range& range) {
    FastCorners fast;
    std::vector<FastCorner> candidates;
    for (int r = range.start; r < range.end; ++r) {
      const int top = area.y + (r * area.height + rows - 1) / rows;
      const int bottom = area.y + ((r + 1) * area.height + rows - 1) / rows;
      Cell* cells = &cells_[static_cast<size_t>(r) * columns];
      int wanted = 0;
      for (int c = 0; c < columns; ++c) wanted += std::max(0, cells[c].vacant);
      if (wanted == 0) continue;
      const cv::Rect strip(area.x, top, area.width, bottom - top);
      fast.find(image, strip, kScores.back());
      for (int score : kScores) {
        candidates.clear();
        fast.append(score, candidates);
        candidates.erase(std::remove_if(candidates.begin(), candidates.end(),
                                        [&](const FastCorner& candidate) {
                                          const cv::Point2f point = candidate.position;
                                          const Cell& cell = cells[column(point.x)];
                                          return cell.vacant <= 0 || !farFromAll(point, cell.taken);
                                        }),
                         candidates.end());
        std::sort(candidates.begin(), candidates.end(), strongerFirst);
        for (const FastCorner& candidate : candidates) {
          const cv::Point2f point = candidate.position;
          Cell& cell = cells[column(point.x)];
          if (cell.vacant <= 0 || !farFromAll(point, cell.taken)) continue;
          --cell.vacant;
          --wanted;
          cell.taken.push_back(point);
          found[r].push_back(point);
        }
        if (3 * wanted < columns * kPerCell) break;
      }
    }
  });
  for (const auto& of_row : found) corners.insert(corners.end(), of_row.begin(), of_row.end());
}

}  // namespace predictive_stereo
