#include "detection/steady_ground.h"

#include <cmath>

namespace predictive_stereo {
namespace {

constexpr double kMostChange = 0.1;                  // of the camera's height above it
const double kLeastCos = std::cos(20 * M_PI / 180);  // of the angle between the two planes

bool areAlike(const GroundPlane& one, const GroundPlane& other) {
  return one.normal.dot(other.normal) > kLeastCos &&
         std::abs(std::log(one.camera_height_m / other.camera_height_m)) < kMostChange;
}

}  // namespace

void SteadyGround::setFrame(const StereoRig& rig, const DepthCells& cells) {
  const std::optional<GroundPlane> last = candidate_;
  candidate_ = findGroundPlane(rig, cells, last);
  plane_.reset();
  if (last && candidate_ && areAlike(*last, *candidate_)) plane_ = candidate_;
}

}  // namespace predictive_stereo
