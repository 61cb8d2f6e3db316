/// Pairs of a camera with something changed. The messages of the original stay as they are.
#pragma once

#include <boost/make_shared.hpp>
#include <functional>

#include "nodelets/stereo_messages.h"

namespace predictive_stereo {

inline sensor_msgs::ImagePtr copyOf(const sensor_msgs::ImageConstPtr& image) {
  return boost::make_shared<sensor_msgs::Image>(*image);
}

inline void changeInfos(StereoPair& pair,
                        const std::function<void(sensor_msgs::CameraInfo&)>& change) {
  for (auto* info : {&pair.left_info, &pair.right_info}) {
    const auto changed = boost::make_shared<sensor_msgs::CameraInfo>(**info);
    change(*changed);
    *info = changed;
  }
}

inline StereoPair withStamp(StereoPair pair, ros::Time stamp) {
  for (auto* image : {&pair.left, &pair.right}) {
    const auto stamped = copyOf(*image);
    stamped->header.stamp = stamp;
    *image = stamped;
  }
  changeInfos(pair, [&](sensor_msgs::CameraInfo& info) { info.header.stamp = stamp; });
  return pair;
}

}  // namespace predictive_stereo
