#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "detection/point_tracks.h"

namespace predictive_stereo {

/// Points that may be of one object, and where all of them together were found before.
struct SuspectGroup {
  std::vector<cv::Point> points_px;
  cv::Point2f shift_px;  ///< against where the static world puts them
  float gain = 0;        ///< mismatch of the static world by that of the shift
};

/// Groups points by place and depth, not wider than a vehicle is long, and looks for each group as
/// a whole: texture that is too weak or too alike for single points, and too small for the coarse
/// levels of a pyramid, is found that way. Groups that the static world explains about as well, and
/// those of less than params.min_tracks points, are left out.
/// @param points_px  row by row.
/// @param seconds  between both frames.
std::vector<SuspectGroup> groupSuspects(const TrackingView& view,
                                        const MotionDetectionParams& params,
                                        const std::vector<cv::Point>& points_px, double seconds);

/// Follows the points of groups from where these were found, at most params.max_tracks.
std::vector<PointTrack> followGroups(const TrackingView& view, const MotionDetectionParams& params,
                                     const std::vector<SuspectGroup>& groups);

}  // namespace predictive_stereo
