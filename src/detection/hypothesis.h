#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <type_traits>
#include <vector>

#include "detection/frame_history.h"
#include "detection/point_tracks.h"
#include "detection/tracker.h"

namespace predictive_stereo {

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

/// Motion of a group of points since a past frame. None if too few of them are found there, or if
/// it is not significant.
std::optional<Displacement> motionOf(const PastView& view,
                                     const std::vector<cv::Point>& lattice_points);

/// The hypothesis of a known object at its predicted position. None if too few pixels there have
/// its disparity.
std::optional<Hypothesis> hypothesisOf(const PastView& view, const ObjectTrack& known);

/// Largest number of hypotheses per frame, which bounds the time. Crowds and foliage have about 5
/// across the line of sight and 20 along it; the largest ones come first.
constexpr size_t kMostAcross = 8, kMostAlong = 12;

/// The first `most` results of `make`; further items are not used.
/// @param make  called with an item; returns a std::optional.
template <class Items, class Make>
auto firstResults(size_t most, const Items& items, const Make& make) {
  std::vector<typename std::invoke_result_t<Make, decltype(*items.begin())>::value_type> made;
  for (const auto& item : items) {
    if (made.size() == most) break;
    if (auto one = make(item)) made.push_back(std::move(*one));
  }
  return made;
}

}  // namespace predictive_stereo
