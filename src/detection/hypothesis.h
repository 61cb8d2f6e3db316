#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "detection/frame_view.h"
#include "detection/residual_groups.h"
#include "detection/tracker.h"

namespace predictive_stereo {

/// A guess that something at this depth moves like this.
struct Hypothesis {
  /// Who found it: AcrossChannel, AlongChannel, or the tracker, who knows it.
  enum class Source { kAcross, kAlong, kKnown };

  Source source = Source::kAcross;
  std::vector<cv::Point> seeds;                          ///< lattice points that belong to it
  float disparity_px = 0;                                ///< median of the seeds
  float nearest_px = 0, farthest_px = 0;                 ///< disparities of its layer
  Eigen::Vector3d moved_m = Eigen::Vector3d::Zero();     ///< in the previous camera's frame
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of moved_m; not of what is known
};

/// Sets the layer: the disparities of the seeds, and a little beyond.
void setLayer(const FrameView& frame, Hypothesis& hypothesis);

/// What a group of residuals moved by since a frame of the past.
struct GroupMotion {
  Displacement fit;
  std::vector<cv::Point> sample_px;  ///< points that were followed
  cv::Point2f shift_px;              ///< of all of them, against the static world
};
/// None where the group is too small, or too few of its points are found again.
std::optional<GroupMotion> motionOf(const FrameView& frame, const PastFrame& past,
                                    const ResidualGroup& group);
/// Whether a group is as large as an object has to be.
bool isLargeEnough(const FrameView& frame, const ResidualGroup& group);

/// A known object where it should be, with its layer. None where it hardly moves, or too little of
/// its disparity is there.
std::optional<Hypothesis> hypothesisOf(const FrameView& frame, const PastFrame& past,
                                       const ObjectTrack& known);

/// Lattice points as pixels, evenly thinned.
std::vector<cv::Point> sampleOf(const std::vector<cv::Point>& lattice_points);

}  // namespace predictive_stereo
