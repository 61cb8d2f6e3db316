#pragma once

#include <image_transport/image_transport.h>
#include <ros/node_handle.h>
#include <sensor_msgs/Image.h>
#include <stereo_msgs/DisparityImage.h>

#include <mutex>
#include <optional>

#include "nodelets/disparity_processor.h"
#include "nodelets/health.h"
#include "nodelets/mask_input.h"
#include "nodelets/nodelet_params.h"
#include "nodelets/outputs.h"
#include "nodelets/stereo_messages.h"

namespace predictive_stereo {

/// The topics of disparity_views.h, made while they have subscribers. The clouds, points2 and
/// points2_static, need the mask of moving objects of their frame, which arrives a little later, or
/// not at all.
///
/// Thread-safe.
class ViewOutput {
 public:
  ViewOutput(ros::NodeHandle& node, Outputs& outputs, Health& health, const PointsParams& params);

  bool needsMask() const {
    return cloud_.getNumSubscribers() > 0 || static_cloud_.getNumSubscribers() > 0;
  }
  /// Publishes all but the clouds, which may wait until their mask or the next frame arrives.
  void publish(const DisparityMessages& messages, const StereoPair& pair, const MaskInput& masks);
  /// Publishes the clouds that wait for this mask.
  void finishClouds(const sensor_msgs::ImageConstPtr& mask);
  void forget();

 private:
  struct Pending {
    stereo_msgs::DisparityImageConstPtr disparity;
    StereoPair pair;
  };
  void publishClouds(const sensor_msgs::Image* mask);
  void reportMissingMask(bool missing);

  Health& health_;
  const PointsParams params_;
  ros::Publisher disparity_, standard_deviation_, depth_, depth_info_, cloud_, static_cloud_;
  image_transport::Publisher colour_;
  std::mutex mutex_;
  std::optional<Pending> pending_;
  int missing_masks_ = 0;  // consecutive clouds without a mask
};

}  // namespace predictive_stereo
