#pragma once

#include "detection/tracker.h"
#include "predictive_stereo/moving_objects.h"

namespace predictive_stereo {

/// Area in common / area of both together.
double intersectionOverUnion(const cv::Rect2d& a, const cv::Rect2d& b);

/// Whether two observations overlap and have about the same depth.
bool overlaps(const MotionDetectionParams& params, const Observation& seen,
              const Observation& object);

/// Whether `seen` is a part of `object`: it is beside it and has the same velocity, like the side
/// of a vehicle whose rear was found; or it is behind it, where the background was occluded in the
/// past.
/// @param largest_share  largest area of a part, as a share of the object's.
bool belongsTo(const Observation& seen, const Observation& object, double largest_share);

}  // namespace predictive_stereo
