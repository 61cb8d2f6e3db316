#pragma once

#include <boost/pointer_cast.hpp>
#include <vector>

#include "nodelets/stereo_messages.h"
#include "nodelets/synced_topics.h"

namespace predictive_stereo {

/// The four topics of a stereo camera.
struct StereoInput {
  using Frame = StereoPair;

  static std::vector<SyncedTopics::Topic> topics() {
    using Type = SyncedTopics::Type;
    return {{"left/image_rect", Type::kCameraImage},
            {"left/camera_info", Type::kInfo},
            {"right/image_rect", Type::kCameraImage},
            {"right/camera_info", Type::kInfo}};
  }
  static SyncedTopics::Cures cures() {
    return {"run in the camera's namespace (launch argument camera:=<namespace>), or remap", "",
            ""};
  }
  static StereoPair frame(const SyncedTopics::Set& set) {
    using boost::static_pointer_cast;
    return {static_pointer_cast<const sensor_msgs::Image>(set[0]),
            static_pointer_cast<const sensor_msgs::Image>(set[2]),
            static_pointer_cast<const sensor_msgs::CameraInfo>(set[1]),
            static_pointer_cast<const sensor_msgs::CameraInfo>(set[3])};
  }
};

}  // namespace predictive_stereo
