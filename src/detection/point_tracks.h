#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <vector>

#include "detection/frame_history.h"
#include "predictive_stereo/moving_objects.h"

namespace predictive_stereo {

constexpr float kLeastDisparityVariance_px2 = 0.09f;  ///< of any disparity
/// Standard deviation of the disparity where a point was found in the previous frame.
constexpr double kPreviousDisparitySigma_px = 0.5;

/// A point of the current frame that was found in the previous one.
struct PointTrack {
  cv::Point2f position;       ///< now [px]
  float disparity_px = 0;     ///< now
  float variance_px2 = 0;     ///< of disparity_px
  Eigen::Vector3d static_m;   ///< where it is now, in the previous camera's frame
  Eigen::Vector3d static_px;  ///< (x, y, d) where a static point would have been before
  Eigen::Vector3d found_px;   ///< (x, y, d) where it was found; d < 0: unknown
  double mahalanobis = 0;     ///< squared, of found_px - static_px given the errors of both
  bool moving = false;

  Eigen::Vector2d flow() const { return (found_px - static_px).head<2>(); }
};

/// Inputs to follow points back into the previous frame.
struct TrackingView {
  const StereoRig& rig;
  const DisparityRange& range;
  const ImagePyramid& current;
  const cv::Mat1f& disparity_px;
  const cv::Mat1f& variance_px2;
  const RememberedFrame& previous;
  const Eigen::Isometry3d& T_prev_cam;
};

/// Follows lattice points back by Lucas-Kanade and separates moving from static ones. Points
/// that are not found are left out.
/// @param shift_px  where the search begins, from where a static point would have been.
std::vector<PointTrack> followPoints(const TrackingView& view, const MotionDetectionParams& params,
                                     const std::vector<cv::Point>& points_px,
                                     cv::Point2f shift_px = {});

/// A displacement in the previous camera's frame [m] and its covariance.
struct Displacement {
  Eigen::Vector3d moved_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
  std::vector<size_t> inliers;  ///< of the tracks that were used

  /// Whether it is longer than its error, by params.min_mahalanobis.
  bool isSignificant(const MotionDetectionParams& params) const;
};

/// The translation that moves these points from where they were to where they are, robustly.
Displacement fitDisplacement(const StereoRig& rig, const MotionDetectionParams& params,
                             const std::vector<PointTrack>& tracks,
                             const std::vector<size_t>& members);
/// The same of all tracks.
Displacement fitDisplacement(const StereoRig& rig, const MotionDetectionParams& params,
                             const std::vector<PointTrack>& tracks);

/// Groups moving points that are near each other in space and move alike.
std::vector<std::vector<size_t>> clusterTracks(const StereoRig& rig,
                                               const MotionDetectionParams& params,
                                               const std::vector<PointTrack>& tracks);

}  // namespace predictive_stereo
