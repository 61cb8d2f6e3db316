#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <vector>

#include "detection/frame_history.h"

namespace predictive_stereo {

/// Standard deviation of a tracked point's position [px].
constexpr double kFlowSigma_px = 0.4;
constexpr float kLeastDisparityVariance_px2 = 0.09f;  ///< minimum for current disparities
/// Standard deviation of the previous frame's disparity at the tracked position.
constexpr double kPreviousDisparitySigma_px = 0.5;

/// Distance along the line of sight between points of an object, relative to
/// MotionDetectionParams::link_distance_m.
constexpr double kLinkDepth = 0.6;

/// A point of the current frame that was tracked into the previous one.
struct PointTrack {
  cv::Point2f position;       ///< in the current frame [px]
  float disparity_px = 0;     ///< in the current frame
  float variance_px2 = 0;     ///< of disparity_px
  Eigen::Vector3d point_m;    ///< current position in the current camera's frame
  Eigen::Vector3d static_m;   ///< current position in the previous camera's frame
  Eigen::Vector3d static_px;  ///< (x, y, d) in the previous frame if the point is static
  Eigen::Vector3d found_px;   ///< (x, y, d) in the previous frame as tracked; d < 0: unknown
  /// Whether the squared Mahalanobis distance of found_px and static_px reaches
  /// MotionDetectionParams::min_mahalanobis.
  bool moving = false;

  Eigen::Vector2d flow() const { return (found_px - static_px).head<2>(); }
};

/// Tracks lattice points into the previous frame by Lucas-Kanade. Points that are not found are
/// left out.
/// @param shift_px  start of the search, relative to a static point.
std::vector<PointTrack> followPoints(const PastView& view, const std::vector<cv::Point>& points_px,
                                     cv::Point2f shift_px = {});

/// A displacement in the previous camera's frame [m] and its covariance.
struct Displacement {
  Eigen::Vector3d moved_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
  std::vector<size_t> inliers;  ///< of the tracks

  /// Whether its squared Mahalanobis distance from zero reaches params.min_mahalanobis.
  bool isSignificant(const MotionDetectionParams& params) const;
};

/// Robust fit of the translation of these points since the previous frame.
Displacement fitDisplacement(const PastView& view, const std::vector<PointTrack>& tracks);

/// Groups moving points that are close in space and move alike; the largest group first.
std::vector<std::vector<PointTrack>> clusterTracks(const PastView& view,
                                                   const std::vector<PointTrack>& tracks);

}  // namespace predictive_stereo
