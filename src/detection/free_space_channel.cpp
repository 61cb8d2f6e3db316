#include "detection/free_space_channel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <opencv2/imgproc.hpp>

namespace predictive_stereo {
namespace {

constexpr int kFewestCells = 15;
constexpr double kLeastFixed = 0.4;  // share of the compared cells, ground included
constexpr float kNearer_px = 2;      // of what can hide the lower end

struct CellCounts {
  int moved = 0, fixed = 0;
};

CellCounts countCells(const Obstacles::Cells& obstacle, const FreeSpaceEvidence& evidence) {
  CellCounts counts;
  for (const cv::Point p : obstacle) {
    counts.moved += evidence.moved(p) != 0;
    counts.fixed += evidence.fixed(p) != 0;
  }
  return counts;
}

// Whether enough of what can be compared is where it was. A near person may fill most of the view.
bool poseFits(const FreeSpaceEvidence& evidence) {
  const int moved = cv::countNonZero(evidence.moved), fixed = cv::countNonZero(evidence.fixed);
  return fixed >= kLeastFixed * (moved + fixed);
}

bool hasMoved(int cells, const CellCounts& counts) {
  return counts.moved >= kLeastMoved * cells && counts.moved >= counts.fixed;
}

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

void FreeSpaceChannel::setFrame(const DetectionInput& input, const DisparityRange& range) {
  cells_.setFrame(range, input.measured_disparity_px, input.measured_variance_px2);
  ground_.setFrame(input.rig, cells_);
}

std::vector<ObservedObject> FreeSpaceChannel::find(const DetectionInput& input,
                                                   const DisparityRange& range,
                                                   const MotionDetectionParams& params,
                                                   const cv::Mat1b& half_image) {
  obstacles_ = findObstacles(input.rig, cells_, ground());
  free_space_.compare(input, cells_, half_image, obstacleWidths(obstacles_, cells_));
  std::vector<ObservedObject> objects;
  if (!poseFits(free_space_.evidence())) {
    free_space_.reset();
    obstacles_ = {};
    return objects;
  }
  free_space_.remember(input, cells_, half_image);
  for (int k = 0; k < obstacles_.size(); ++k) {
    const Obstacles::Cells obstacle = obstacles_[k];
    if (obstacle.size() < kFewestCells) continue;
    const CellCounts counts = countCells(obstacle, free_space_.evidence());
    if (!hasMoved(obstacle.size(), counts)) continue;
    const cv::Rect area = obstacle.area();
    ObservedObject object = objectOf(obstacle, area, cells_, range, input.measured_disparity_px);
    Observation& seen = object.observation;
    if (!measureShape(input.rig, range, input.measured_disparity_px, object) ||
        !isPossible(input.rig, params, obstacle, area, seen.distance_m))
      continue;
    seen.centre_covariance =
        centreCovariance(input.rig, input.rig.disparityTimesDepth() / seen.centre_m.z());
    seen.score = static_cast<double>(counts.moved) / (counts.moved + counts.fixed);
    objects.push_back(std::move(object));
  }
  return objects;
}

void FreeSpaceChannel::complete(const DetectionInput& input, const DisparityRange& range,
                                const MotionDetectionParams& params, ObservedObject& part) const {
  if (obstacles_.size() == 0) return;
  const Obstacles::Cells obstacle = wholeObstacle(part, obstacles_, free_space_.evidence());
  if (obstacle.size() == 0) return;
  const cv::Rect area = obstacle.area();
  ObservedObject whole =
      joined(part, objectOf(obstacle, area, cells_, range, input.measured_disparity_px));
  if (measureShape(input.rig, range, input.measured_disparity_px, whole) &&
      isPossible(input.rig, params, obstacle, area, whole.observation.distance_m))
    part = std::move(whole);
}

void FreeSpaceChannel::reset() {
  free_space_.reset();
  ground_.reset();
}

// Whether an obstacle's size and height above the ground are those of an object.
bool FreeSpaceChannel::isPossible(const StereoRig& rig, const MotionDetectionParams& params,
                                  const Obstacles::Cells& obstacle, const cv::Rect& area,
                                  double distance_m) const {
  const double cell_m = kCellSide_px * distance_m;
  Extent extent{area.width * cell_m / rig.fx_px, area.height * cell_m / rig.fy_px, {}};
  if (ground()) {
    Extent::Heights heights{std::numeric_limits<double>::infinity(), 0};
    for (const cv::Point p : obstacle) {
      const double above_m = ground()->heightOf(p, cells_.disparity_px(p));
      heights.foot_m = std::min(heights.foot_m, above_m);
      heights.top_m = std::max(heights.top_m, above_m);
    }
    extent.above_ground = heights;
    // A camera that looks down sees less of the height.
    extent.height_m = std::max(extent.height_m, std::min(heights.top_m, params.max_height_m));
  }
  const auto disparity_px = static_cast<float>(rig.disparityTimesDepth() / distance_m);
  const cv::Rect box_px(kCellSide_px * area.tl(), area.size() * kCellSide_px);
  return isPlausible(params, extent,
                     lowerEndOf(cells_, ground(), box_px, disparity_px + kNearer_px), distance_m);
}

}  // namespace predictive_stereo
