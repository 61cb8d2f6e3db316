#include "detection/free_space_channel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "detection/constants.h"

namespace predictive_stereo {
namespace {

struct CellCounts {
  int moved = 0, fixed = 0;
};

std::vector<CellCounts> countCells(const Obstacles& obstacles, const FreeSpaceEvidence& evidence) {
  std::vector<CellCounts> counts(obstacles.sizes.size());
  const int *const number = obstacles.number[0], all = static_cast<int>(obstacles.number.total());
  for (int i = 0; i < all; ++i) {
    if (number[i] < 0) continue;
    CellCounts& of_obstacle = counts[static_cast<size_t>(number[i])];
    of_obstacle.moved += evidence.moved.data[i] != 0;
    of_obstacle.fixed += evidence.fixed.data[i] != 0;
  }
  return counts;
}

// Whether enough of what can be compared is where it was. A near person may fill most of the view.
bool poseFits(const FreeSpaceEvidence& evidence) {
  const int moved = cv::countNonZero(evidence.moved), fixed = cv::countNonZero(evidence.fixed);
  return fixed >= kLeastFixed * (moved + fixed);
}

cv::Rect pixelsOf(const cv::Rect& cells) {
  return {kCellSide_px * cells.tl(), cells.size() * kCellSide_px};
}

// Measures an object. False if the obstacle's size and height above the ground are not those of
// one.
bool measureIfPossible(const FrameView& frame, const std::vector<cv::Point>& obstacle,
                       Observation& object) {
  if (!measureShape(frame.input, frame.range, object)) return false;
  const StereoRig& rig = frame.input.rig;
  const double distance_m = object.distance_m, cell_m = kCellSide_px * distance_m;
  const cv::Rect area = cv::boundingRect(obstacle);
  Extent extent{area.width * cell_m / rig.fx_px, area.height * cell_m / rig.fy_px, {}};
  if (frame.ground) {
    Extent::Heights heights{std::numeric_limits<double>::infinity(), 0};
    for (const cv::Point p : obstacle) {
      const double above_m = frame.ground->heightOf(p, frame.cells.disparity_px(p));
      heights.foot_m = std::min(heights.foot_m, above_m);
      heights.top_m = std::max(heights.top_m, above_m);
    }
    extent.above_ground = heights;
    // A camera that looks down sees less of the height.
    extent.height_m = std::max(extent.height_m, std::min(heights.top_m, frame.params.max_height_m));
  }
  const auto disparity_px = static_cast<float>(rig.disparityTimesDepth() / distance_m);
  const LowerEnd lower_end = lowerEndOf(frame.cells, frame.ground, pixelsOf(area), disparity_px);
  return isPlausible(frame.params, extent, lower_end);
}

}  // namespace

Observation objectOf(const FrameView& frame, const std::vector<cv::Point>& obstacle) {
  const cv::Mat1f& disparity_px = frame.input.measured_disparity_px;
  const cv::Rect box = pixelsOf(cv::boundingRect(obstacle));
  Observation object;
  object.box_px = box;
  object.mask = cv::Mat1b::zeros(box.size());
  for (const cv::Point cell : obstacle) {
    const float d = frame.cells.disparity_px(cell);
    const cv::Point first = kCellSide_px * cell;
    for (int y = first.y; y < first.y + kCellSide_px; ++y)
      for (int x = first.x; x < first.x + kCellSide_px; ++x)
        if (frame.range.isValid(disparity_px(y, x)) &&
            std::abs(disparity_px(y, x) - d) <= kDisparityError_px + kSameSurface * d)
          object.mask(y - box.y, x - box.x) = 255;
  }
  return object;
}

std::vector<Observation> FreeSpaceChannel::find(const FrameView& frame, DepthCells& cells) {
  const DetectionInput& input = frame.input;
  const cv::Mat1b& half_image = frame.current.pyramid.level(1);
  const Obstacles& obstacles = frame.obstacles;
  free_space_.compare(input, cells, half_image, obstacleWidths(obstacles, cells));
  std::vector<Observation> objects;
  if (!poseFits(free_space_.evidence())) {
    free_space_.reset();
    return objects;
  }
  free_space_.remember(input, cells, half_image);
  const std::vector<CellCounts> counts = countCells(obstacles, free_space_.evidence());
  for (size_t k = 0; k < counts.size(); ++k) {
    const int size = obstacles.sizes[k];
    const auto [moved, fixed] = counts[k];
    if (size < static_cast<int>(kFewestPoints) || moved < kLeastMoved * size) continue;
    const std::vector<cv::Point> obstacle = obstacles.cellsOf(static_cast<int>(k));
    Observation seen = objectOf(frame, obstacle);
    if (!measureIfPossible(frame, obstacle, seen)) continue;
    seen.centre_covariance =
        centreCovariance(input.rig, input.rig.disparityTimesDepth() / seen.centre_m.z());
    seen.score = static_cast<double>(moved) / (moved + fixed);
    objects.push_back(std::move(seen));
  }
  return objects;
}

}  // namespace predictive_stereo
