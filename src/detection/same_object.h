#pragma once

#include "detection/tracker.h"
#include "predictive_stereo/moving_objects.h"

namespace predictive_stereo {

/// Whether it overlaps an object of about the same depth.
bool overlaps(const MotionDetectionParams& params, const Observation& seen,
              const Observation& object);

/// Whether it goes on where an object of the same velocity ends, as the side of a vehicle does
/// whose rear was found, or lies behind the object, where the past was hidden.
/// @param largest_share  of the object's area that a part of it may have.
bool belongsTo(const MotionDetectionParams& params, const Observation& seen,
               const Observation& object, double largest_share);

}  // namespace predictive_stereo
