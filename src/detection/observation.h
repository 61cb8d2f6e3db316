/// An object as one frame shows it: its shape, whether it is plausible, and whether two are the
/// same.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

#include "detection/depth_cells.h"
#include "detection/ground_plane.h"
#include "predictive_stereo/moving_objects.h"

namespace predictive_stereo {

/// An object in one frame.
struct Observation {
  cv::Rect box_px;
  cv::Mat1b mask;  ///< 255 on its pixels; of the size of its box
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  ///< in the left camera's optical frame
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();    ///< along the axes of that frame
  double distance_m = 0;                               ///< depth of its nearest part
  Eigen::Matrix3d centre_covariance = Eigen::Matrix3d::Zero();  ///< [m^2], in that frame
  /// Whether the velocity was measured in this frame alone, as the mean over `velocity_span_s`.
  /// Otherwise it is that of the object's track, or 0.
  bool has_velocity = false;
  double velocity_span_s = 0;
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();  ///< in the odom frame
  Eigen::Matrix3d velocity_covariance = Eigen::Matrix3d::Zero();
  double score = 0;
};

/// Sets centre, size and distance of an object whose box and mask are known: of the 3-D box around
/// its pixels with a positive disparity, without the outermost 5 % at both ends of each axis. False
/// if there are fewer than kFewestPoints such pixels.
bool measureShape(const DetectionInput& input, const DisparityRange& range, Observation& seen);

/// Covariance [m^2] of the centre of an object with this disparity, in the camera's frame.
Eigen::Matrix3d centreCovariance(const StereoRig& rig, double disparity_px);

/// The pixels of both, without thin ends of the whole: what a matcher adds at silhouettes.
/// All but box_px and mask is that of the part.
Observation joined(const Observation& part, const Observation& whole);

/// What the lower end of an object's visible part is.
enum class LowerEnd {
  kFoot,    ///< the object's lower end
  kHidden,  ///< an occlusion by a nearer surface
  kCut      ///< the lower edge of the image
};
/// @param ground  none: what is below an object counts as the ground that it stands on.
/// @param nearest_px  largest disparity of the object.
LowerEnd lowerEndOf(const DepthCells& cells, const std::optional<GroundPlane>& ground,
                    const cv::Rect& box_px, float nearest_px);

/// What is visible of an object.
struct Extent {
  struct Heights {
    double foot_m, top_m;
  };
  double width_m, height_m;
  std::optional<Heights> above_ground;  ///< of its ends; none: no ground is in view
};
/// Whether size and height above the ground are possible for an object.
bool isPlausible(const MotionDetectionParams& params, const Extent& extent, LowerEnd lower_end);

/// Area in common / area of both together.
double intersectionOverUnion(const cv::Rect2d& a, const cv::Rect2d& b);

/// Whether two observations overlap and have about the same depth.
bool overlaps(const MotionDetectionParams& params, const Observation& seen,
              const Observation& object);

/// Whether `seen` is a small part of `object`: it is beside it and has the same velocity, like the
/// side of a vehicle whose rear was found.
bool belongsTo(const MotionDetectionParams& params, const Observation& seen,
               const Observation& object);

/// Whether two observations are parts of one object, like the ends of a car with a dark door
/// between them: they have the same velocity and depth, and so has the surface between them, which
/// must not be larger than they are.
bool moveAsOne(const DetectionInput& input, const MotionDetectionParams& params,
               const Observation& one, const Observation& other);

}  // namespace predictive_stereo
