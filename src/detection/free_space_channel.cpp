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
constexpr int kBelow = 3;            // rows of cells in which something nearer hides the lower end
constexpr float kNearer_px = 2;

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
        !isPlausible(input, params, obstacle, area, seen.distance_m))
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
      isPlausible(input, params, obstacle, area, whole.observation.distance_m))
    part = std::move(whole);
}

void FreeSpaceChannel::reset() {
  free_space_.reset();
  ground_.reset();
}

// Whether size and height above the ground are plausible for an object.
bool FreeSpaceChannel::isPlausible(const DetectionInput& input, const MotionDetectionParams& params,
                                   const Obstacles::Cells& obstacle, const cv::Rect& area,
                                   double distance_m) const {
  const StereoRig& rig = input.rig;
  const double cell_m = kCellSide_px * distance_m;
  const double width_m = area.width * cell_m / rig.fx_px;
  double height_m = area.height * cell_m / rig.fy_px;
  if (width_m < params.min_width_m || width_m > params.max_width_m ||
      height_m > params.max_height_m)
    return false;
  if (area.br().y >= cells_.disparity_px.rows) return true;  // cut by the image
  if (ground()) {
    double foot_m = std::numeric_limits<double>::infinity();
    for (const cv::Point p : obstacle) {
      const double above_m = ground()->heightOf(p, cells_.disparity_px(p));
      foot_m = std::min(foot_m, above_m);
      height_m = std::max(height_m, above_m);  // a camera that looks down sees no height
    }
    const auto disparity_px = static_cast<float>(rig.disparityTimesDepth() / distance_m);
    const bool is_hidden = isHiddenBelow(area, disparity_px);
    if (foot_m > highestEnd_m(params, is_hidden, distance_m)) return false;
  }
  return height_m >= params.min_height_m;
}

// Whether in most columns a nearer obstacle is below.
bool FreeSpaceChannel::isHiddenBelow(const cv::Rect& area, float disparity_px) const {
  const cv::Rect below = cv::Rect(area.x, area.br().y, area.width, kBelow) &
                         cv::Rect(cv::Point(), cells_.disparity_px.size());
  int hidden = 0;
  for (int u = below.x; u < below.br().x; ++u)
    for (int v = below.y; v < below.br().y; ++v) {
      const float d = cells_.disparity_px(v, u);
      if (d <= disparity_px + kNearer_px || ground()->heightOf({u, v}, d) <= kGroundMargin_m)
        continue;
      ++hidden;
      break;
    }
  return 2 * hidden > area.width;
}

}  // namespace predictive_stereo
