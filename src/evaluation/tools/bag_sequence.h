#pragma once

#include <memory>
#include <string>

#include "evaluation/detection_score.h"
#include "evaluation/sequence.h"
#include "predictive_stereo/MovingObject.h"
#include "tools/stereo_bag.h"

namespace predictive_stereo {

/// The stereo pairs of a bag, without disparity truth; frame 0 is the first pair. Moving
/// objects have ground truth if the bag has <camera>/truth/moving_objects, as from street_to_bag.
/// @throws std::runtime_error if the bag cannot be read, or has no such pairs.
std::unique_ptr<Sequence> bagSequence(const std::string& path, const StereoTopicChoice& choice);

/// The object from which the message was made.
DetectedObject detectedObject(const MovingObject& message);

/// A detector that returns the recorded messages of a bag's topic moving_objects, written by
/// `replay` or by the nodelets. Frames are identified by their stamps. Frames without a message
/// have no objects.
/// @throws std::runtime_error if the bag cannot be read, has no such topic, or has no stamp of the
///   sequence.
Detector recordedDetector(const std::string& path, const Sequence& sequence);

}  // namespace predictive_stereo
