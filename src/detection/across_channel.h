#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "detection/point_tracks.h"
#include "detection/suspicion.h"
#include "detection/verification.h"

namespace predictive_stereo {

/// Points that may belong to one object, and their common displacement since the past frame.
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

/// Points that are tracked into one past frame; an even sample if there are more.
constexpr size_t kMostTracks = 350;
/// Tracks the points of groups from the groups' displacements.
std::vector<PointTrack> followGroups(const PastView& view, const std::vector<SuspectGroup>& groups);

/// Finds objects that move across the line of sight, or fast. Points whose image a static world
/// does not explain are grouped and tracked into one frame of the past. Groups that move alike are
/// verified.
struct AcrossChannel {
  cv::Mat1f static_world;  ///< see compareFrames; of the whole lattice
  Suspects suspects;

  /// Compares the current frame with one of the past.
  /// @param texture  see greyTexture.
  void compare(const PastView& view, const cv::Mat1f& texture);
  /// Adds the objects that it finds; those that were found before are not sought again. Call after
  /// compare(), with the same frames.
  void find(const PastView& view, Verification& verification) const;
};

}  // namespace predictive_stereo
