#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "detection/point_tracks.h"

namespace predictive_stereo {

/// Points that may belong to one object, and their common displacement since the previous frame.
struct SuspectGroup {
  std::vector<cv::Point> points_px;
  cv::Point2f shift_px;  ///< relative to a static world
  float gain = 0;        ///< mismatch of a static world / mismatch of the shift
};

/// Groups points by position and depth, up to the size of a vehicle, and searches for each group as
/// a whole. This finds texture that is too weak or too repetitive for single points, and too small
/// for the coarse levels of a pyramid. Groups that a static world explains about as well, and
/// groups of less than params.min_tracks points, are left out.
/// @param points_px  row by row.
std::vector<SuspectGroup> groupSuspects(const PastView& view,
                                        const std::vector<cv::Point>& points_px);

/// Tracks the points of groups from the groups' displacements, at most
/// DetectionConstants::kMostTracks, and classifies them.
std::vector<PointTrack> followGroups(const PastView& view, const std::vector<SuspectGroup>& groups);

}  // namespace predictive_stereo
