#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>
#include <type_traits>
#include <vector>

#include "detection/frame_history.h"
#include "detection/tracker.h"

namespace predictive_stereo {

/// A point of the current frame that was tracked into the previous one.
struct PointTrack {
  cv::Point2f position;       ///< in the current frame [px]
  float disparity_px = 0;     ///< in the current frame
  float variance_px2 = 0;     ///< of disparity_px
  Eigen::Vector3d point_m;    ///< current position in the current camera's frame
  Eigen::Vector3d static_m;   ///< current position in the previous camera's frame
  Eigen::Vector3d static_px;  ///< (x, y, d) in the past frame if the point is static
  Eigen::Vector3d found_px;   ///< (x, y, d) in the past frame as tracked; d < 0: unknown
  /// Whether the squared Mahalanobis distance of found_px and static_px reaches
  /// MotionDetectionParams::min_mahalanobis.
  bool moving = false;

  Eigen::Vector2d flow() const { return (found_px - static_px).head<2>(); }
};

/// Tracks lattice points into the past frame by Lucas-Kanade. Points that are not found are
/// left out.
/// @param shift_px  start of the search, relative to a static point.
std::vector<PointTrack> followPoints(const PastView& view, const std::vector<cv::Point>& points_px,
                                     cv::Point2f shift_px = {});

/// A displacement in the previous camera's frame [m] and its covariance.
struct Displacement {
  Eigen::Vector3d moved_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
  std::vector<size_t> inliers;  ///< of the tracks
};

/// Robust fit of the translation of these points since the past frame. None if fewer than
/// params.min_tracks of them have it, or if it is not significant: its squared Mahalanobis distance
/// from zero does not reach params.min_mahalanobis.
std::optional<Displacement> significantMotion(const PastView& view,
                                              const std::vector<PointTrack>& tracks);

/// The same for lattice points, which are sought in the past frame and tracked.
std::optional<Displacement> significantMotion(const PastView& view,
                                              const std::vector<cv::Point>& lattice_points);

/// Groups moving points that are close in space and move alike; the largest group first.
std::vector<std::vector<PointTrack>> clusterTracks(const PastView& view,
                                                   const std::vector<PointTrack>& tracks);

/// The hypothesis that an object at some depth moves by some displacement.
struct Hypothesis {
  /// Origin: AcrossChannel, AlongChannel, or a track of the tracker.
  enum class Source { kAcross, kAlong, kKnown };

  Source source = Source::kAcross;
  std::vector<cv::Point> seeds;                          ///< lattice points that belong to it
  float disparity_px = 0;                                ///< median of the seeds
  float nearest_px = 0, farthest_px = 0;                 ///< known disparities of its layer
  Eigen::Vector3d moved_m = Eigen::Vector3d::Zero();     ///< in the previous camera's frame
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of moved_m; not set for kKnown
};

/// Sets the layer: the disparities of the seeds, with a margin.
void setLayer(const FrameView& frame, Hypothesis& hypothesis);

/// The hypothesis of a known object at its predicted position. None if no pixel there has its
/// disparity.
std::optional<Hypothesis> hypothesisOf(const PastView& view, const ObjectTrack& known);

/// The first results of `make`, at most as many as a frame may have hypotheses of one kind, which
/// bounds the time. Crowds and foliage have about 5 across the line of sight and 20 along it.
/// @param items  the largest ones first.
/// @param make  called with an item; returns a std::optional.
template <class Items, class Make>
auto firstResults(const Items& items, const Make& make) {
  constexpr size_t kMost = 8;
  std::vector<typename std::invoke_result_t<Make, decltype(*items.begin())>::value_type> made;
  for (const auto& item : items) {
    if (made.size() == kMost) break;
    if (auto one = make(item)) made.push_back(std::move(*one));
  }
  return made;
}

}  // namespace predictive_stereo
