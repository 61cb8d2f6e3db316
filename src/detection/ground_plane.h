/// The ground as a plane in disparity space.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

#include "detection/depth_cells.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

/// A plane in space: points (x, y) [px] on it have the disparity a x + b y + c [px].
struct GroundPlane {
  double a = 0, b = 0, c = 0;
  double camera_height_m = 0;                         ///< distance of the camera from the plane
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();  ///< unit vector, downwards

  double disparityAt(double x_px, double y_px) const { return a * x_px + b * y_px + c; }
  /// Distance of a surface from the plane [m], positive on the camera's side.
  /// @param disparity_px  positive.
  double heightAt(double x_px, double y_px, double disparity_px) const {
    return camera_height_m * (1 - disparityAt(x_px, y_px) / disparity_px);
  }
  /// The same for a cell.
  double heightOf(cv::Point cell, double disparity_px) const {
    return heightAt(kCellSide_px * cell.x + kCellCentre_px, kCellSide_px * cell.y + kCellCentre_px,
                    disparity_px);
  }
};

/// The plane below the camera that most cells lie on and none shows through. The camera may look
/// down by up to 80 degrees and roll by up to 30.
/// @param last  of the previous frame: tried, too.
/// @returns none if too few cells lie on one plane, the more the higher the camera, or if
///   these may be a wall: no ground is in view.
std::optional<GroundPlane> findGroundPlane(const StereoRig& rig, const DepthCells& cells,
                                           const std::optional<GroundPlane>& last);

/// The ground of a sequence: a plane that two successive frames show. Where the ground has no
/// texture, each frame has another plane, of noise and walls.
class SteadyGround {
 public:
  void setFrame(const StereoRig& rig, const DepthCells& cells);
  /// Of this frame; none if it has no ground.
  const std::optional<GroundPlane>& plane() const { return plane_; }
  void reset() { *this = SteadyGround(); }

 private:
  std::optional<GroundPlane> plane_;
  std::optional<GroundPlane> candidate_;  // of this frame, and the first trial of the next one
};

}  // namespace predictive_stereo
