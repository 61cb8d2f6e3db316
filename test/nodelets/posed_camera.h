#pragma once

#include <stereo_msgs/DisparityImage.h>
#include <tf2_ros/transform_broadcaster.h>

#include <boost/make_shared.hpp>
#include <cstring>
#include <string>

#include "nodelet_fixture.h"
#include "nodelets/transforms.h"

namespace predictive_stereo {

inline size_t validPixels(const stereo_msgs::DisparityImage& disparity) {
  size_t valid = 0;
  for (size_t i = 0; i < disparity.image.data.size(); i += sizeof(float)) {
    float d;
    std::memcpy(&d, &disparity.image.data[i], sizeof(d));
    valid += d >= disparity.min_disparity;
  }
  return valid;
}

/// Somebody else sends the poses of the street's camera to tf.
class PosedCameraTest : public NodeletTest {
 protected:
  /// A pair of a camera. Its true pose in the frame "world_of_others" is sent to tf.
  StereoPair moved(int index, const std::string& camera,
                   tf2_ros::TransformBroadcaster& broadcaster) const {
    broadcaster.sendTransform(
        transformMsg(street().stamp(index), "world_of_others", camera,
                     jump_ * street().T_world_base(index) * street().cameraMount()));
    StereoPair pair = street().pair(index);
    auto left = boost::make_shared<sensor_msgs::Image>(*pair.left);
    left->header.frame_id = camera;
    pair.left = left;
    return pair;
  }
  Eigen::Isometry3d jump_ = Eigen::Isometry3d::Identity();  ///< added to the poses that are sent
};

}  // namespace predictive_stereo
