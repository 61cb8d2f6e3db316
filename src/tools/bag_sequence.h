#pragma once

#include <memory>
#include <string>

#include "evaluation/detection_evaluation.h"
#include "evaluation/sequence.h"
#include "predictive_stereo/MovingObject.h"
#include "tools/stereo_topics.h"

namespace predictive_stereo {

/// The stereo pairs of a bag, without disparity truth; frames are counted over the pairs, from 0.
/// Moving objects have truth where the bag has <camera>/truth/moving_objects, as
/// street_to_bag writes it.
/// @throws std::runtime_error where the bag cannot be read, or has no such pairs.
std::unique_ptr<Sequence> bagSequence(const std::string& path, const StereoTopicChoice& choice);

/// The object as it was before it became a message.
DetectedObject detectedObject(const MovingObject& message);

/// Gives what a bag has recorded on its topic moving_objects: output of `replay` or of the
/// nodelets. Frames are known by their stamps; those of which the bag has no message count as
/// frames without objects.
/// @throws std::runtime_error where the bag cannot be read, has no such topic, or has no stamp of
///   the sequence.
Detector recordedDetector(const std::string& path, const Sequence& sequence);

}  // namespace predictive_stereo
