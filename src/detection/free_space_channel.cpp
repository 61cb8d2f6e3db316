#include "detection/free_space_channel.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "detection/object_shape.h"
#include "detection/plausible_object.h"
#include "detection/whole_object.h"

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

}  // namespace

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
