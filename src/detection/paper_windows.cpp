#include "detection/paper_windows.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "detection/observation.h"

namespace predictive_stereo {
namespace {

// The time of merging grows with the square of this; it is 0.05 s.
constexpr size_t kMostWindows = 2000;

// Value k of `count` values with equal steps from `first` to `last`.
int windowSize(int first, int last, int k, int count) {
  if (count < 2) return first;
  return static_cast<int>(std::lround(first + static_cast<double>(last - first) * k / (count - 1)));
}

// The box that a box overlaps most.
struct Pairing {
  size_t partner = 0;
  double iou = -1;
};

}  // namespace

std::vector<cv::Rect> movingWindows(const cv::Mat1f& difference_px,
                                    const PaperDetectionParams& params) {
  cv::Mat1d integral;
  cv::integral(difference_px, integral, CV_64F);
  const int first_row = static_cast<int>(std::ceil(params.skipped_top * difference_px.rows));
  std::vector<cv::Rect> windows;
  for (int k = 0; k < params.window_sizes; ++k) {
    const int width = windowSize(params.smallest_window_width_px, params.largest_window_width_px, k,
                                 params.window_sizes);
    const int height = windowSize(params.smallest_window_height_px, params.largest_window_height_px,
                                  k, params.window_sizes);
    const double least = params.min_mean_difference_px * width * height;
    for (int y = first_row; y + height <= difference_px.rows; y += params.step_px) {
      const double* above = integral[y];
      const double* below = integral[y + height];
      for (int x = 0; x + width <= difference_px.cols; x += params.step_px)
        if (below[x + width] - below[x] - above[x + width] + above[x] >= least)
          windows.emplace_back(x, y, width, height);
    }
  }
  return windows;
}

void mergeBoxes(double min_iou, std::vector<cv::Rect>& boxes) {
  // The best partner of each box among those after it; merging two boxes changes few of them.
  std::vector<Pairing> best(boxes.size());
  const auto findBest = [&](size_t i) {
    best[i] = Pairing();
    for (size_t j = i + 1; j < boxes.size(); ++j) {
      const double iou = intersectionOverUnion(boxes[i], boxes[j]);
      if (iou > best[i].iou) best[i] = {j, iou};
    }
  };
  for (size_t i = 0; i < boxes.size(); ++i) findBest(i);
  while (boxes.size() > 1) {
    size_t i = 0;
    for (size_t k = 1; k < boxes.size(); ++k)
      if (best[k].iou > best[i].iou) i = k;
    if (best[i].iou < min_iou) return;
    const size_t j = best[i].partner;
    boxes[i] |= boxes[j];
    boxes.erase(boxes.begin() + static_cast<std::ptrdiff_t>(j));
    best.erase(best.begin() + static_cast<std::ptrdiff_t>(j));
    for (size_t k = 0; k < boxes.size(); ++k) {
      if (k == i || best[k].partner == i || best[k].partner == j) {
        findBest(k);
        continue;
      }
      if (best[k].partner > j) --best[k].partner;
      if (k < i) {
        const double iou = intersectionOverUnion(boxes[k], boxes[i]);
        if (iou > best[k].iou || (iou == best[k].iou && i < best[k].partner)) best[k] = {i, iou};
      }
    }
  }
}

std::vector<cv::Rect> movingBoxes(const cv::Mat1f& difference_px,
                                  const PaperDetectionParams& params) {
  PaperDetectionParams coarse = params;
  std::vector<cv::Rect> boxes = movingWindows(difference_px, coarse);
  while (boxes.size() > kMostWindows) {
    coarse.step_px *= 2;
    boxes = movingWindows(difference_px, coarse);
  }
  mergeBoxes(params.min_merge_iou, boxes);
  boxes.erase(std::remove_if(boxes.begin(), boxes.end(),
                             [&](const cv::Rect& box) {
                               return box.width < params.min_width_px ||
                                      box.height < params.min_height_px;
                             }),
              boxes.end());
  return boxes;
}

}  // namespace predictive_stereo
