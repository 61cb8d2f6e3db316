/// What a bag needs before the nodelets can use it.
#pragma once

#include <rosbag/bag.h>

#include <string>
#include <vector>

#include "tools/stereo_topics.h"

namespace predictive_stereo {

struct BagFinding {
  enum class Level {
    kGood,    ///< as it should be
    kAdvice,  ///< works, with the launch arguments given, or worse than it could
    kFault,   ///< the bag cannot be used like this
  };
  Level level;
  std::string text;  ///< for advice and faults with the cure
};

struct BagCheck {
  std::vector<BagFinding> findings;
  std::string launch_file;             ///< of this package; empty: no camera was found
  std::vector<std::string> arguments;  ///< for it, without the bag

  bool usable() const;
};

/// Checks topics, images, calibrations, stamps and tf of the bag's first half minute.
/// @param choice  the camera to check; nothing chosen: the first with a known layout.
BagCheck checkBag(const rosbag::Bag& bag, const StereoTopicChoice& choice = {});

}  // namespace predictive_stereo
