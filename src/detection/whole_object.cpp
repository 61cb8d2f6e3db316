#include "detection/whole_object.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>

namespace predictive_stereo {
namespace {

// Largest difference of disparities within a cell: fixed part, and relative to them.
constexpr float kSameSurface_px = 1, kSameSurface = 0.03f;
constexpr double kLeastPart = 0.2;  // share of the cells that the part has
constexpr double kThin = 0.3;       // pixels of a line / of the fullest line

// The cells whose centre is in the object.
cv::Mat1b cellsOf(const ObservedObject& object, cv::Size cells) {
  const cv::Rect box = object.observation.box_px;
  cv::Mat1b inside = cv::Mat1b::zeros(cells);
  for (int v = box.y / kCellSide_px; v < std::min(cells.height, box.br().y / kCellSide_px + 1); ++v)
    for (int u = box.x / kCellSide_px; u < std::min(cells.width, box.br().x / kCellSide_px + 1);
         ++u) {
      const cv::Point centre(kCellSide_px * u + kCellCentre_px, kCellSide_px * v + kCellCentre_px);
      if (box.contains(centre)) inside(v, u) = object.mask(centre - box.tl());
    }
  return inside;
}

// The obstacle that most of these cells belong to; -1: none.
int commonObstacle(const cv::Mat1b& inside, const cv::Mat1i& number) {
  std::map<int, int> votes;
  int most = 0, obstacle = -1;
  for (int v = 0; v < inside.rows; ++v)
    for (int u = 0; u < inside.cols; ++u)
      if (inside(v, u) && number(v, u) >= 0 && ++votes[number(v, u)] > most) {
        obstacle = number(v, u);
        most = votes[obstacle];
      }
  return 2 * most >= cv::countNonZero(inside) ? obstacle : -1;
}

// Without thin lines at the ends.
cv::Range withoutEnds(const std::vector<int>& counts) {
  const double thin = kThin * *std::max_element(counts.begin(), counts.end());
  cv::Range kept(0, static_cast<int>(counts.size()));
  const auto at = [&](int i) { return counts[static_cast<size_t>(i)]; };
  while (!kept.empty() && at(kept.start) <= thin) ++kept.start;
  while (!kept.empty() && at(kept.end - 1) <= thin) --kept.end;
  return kept;
}

cv::Rect withoutEnds(const cv::Mat1b& mask) {
  std::vector<int> columns(static_cast<size_t>(mask.cols)), rows(static_cast<size_t>(mask.rows));
  for (int y = 0; y < mask.rows; ++y)
    for (int x = 0; x < mask.cols; ++x)
      if (mask(y, x)) ++columns[static_cast<size_t>(x)], ++rows[static_cast<size_t>(y)];
  const cv::Range across = withoutEnds(columns), down = withoutEnds(rows);
  return {across.start, down.start, across.size(), down.size()};
}

}  // namespace

ObservedObject objectOf(const Obstacles::Cells& obstacle, const cv::Rect& area,
                        const DepthCells& cells, const DisparityRange& range,
                        const cv::Mat1f& disparity_px) {
  ObservedObject object;
  const cv::Rect box(kCellSide_px * area.tl(), area.size() * kCellSide_px);
  object.observation.box_px = box;
  object.mask.create(box.size());
  object.mask.setTo(0);
  for (const cv::Point cell : obstacle) {
    const float d = cells.disparity_px(cell);
    const cv::Point first = kCellSide_px * cell;
    for (int y = first.y; y < first.y + kCellSide_px; ++y)
      for (int x = first.x; x < first.x + kCellSide_px; ++x)
        if (range.isValid(disparity_px(y, x)) &&
            std::abs(disparity_px(y, x) - d) <= kSameSurface_px + kSameSurface * d)
          object.mask(y - box.y, x - box.x) = 255;
  }
  return object;
}

Obstacles::Cells wholeObstacle(const ObservedObject& part, const Obstacles& obstacles,
                               const FreeSpaceEvidence& evidence) {
  constexpr Obstacles::Cells kNone(nullptr, nullptr);
  const cv::Mat1b inside = cellsOf(part, obstacles.number().size());
  const int k = commonObstacle(inside, obstacles.number());
  if (k < 0) return kNone;
  const Obstacles::Cells whole = obstacles[k];
  int of_part = 0, moved = 0;
  for (const cv::Point p : whole) {
    of_part += inside(p) != 0;
    moved += evidence.moved(p) != 0;
  }
  const auto all = static_cast<double>(whole.size());
  return of_part < kLeastPart * all || moved < kLeastMoved * all ? kNone : whole;
}

ObservedObject joined(const ObservedObject& part, const ObservedObject& whole) {
  const cv::Rect of_part = part.observation.box_px, kept = withoutEnds(whole.mask);
  if (kept.empty()) return part;
  const cv::Rect of_whole = kept + cv::Rect(whole.observation.box_px).tl();
  ObservedObject both{part.observation, {}};
  const cv::Rect box = of_part | of_whole;
  both.observation.box_px = box;
  both.mask = cv::Mat1b::zeros(box.size());
  whole.mask(kept).copyTo(both.mask(of_whole - box.tl()));
  both.mask(of_part - box.tl()).setTo(255, part.mask);
  return both;
}

}  // namespace predictive_stereo
