#pragma once

#include <ros/node_handle.h>
#include <sensor_msgs/Image.h>
#include <stereo_msgs/DisparityImage.h>

#include <mutex>
#include <optional>

#include "nodelets/health.h"
#include "nodelets/mask_input.h"
#include "nodelets/nodelet_params.h"
#include "nodelets/outputs.h"
#include "nodelets/stereo_messages.h"

namespace predictive_stereo {

/// points2 and points2_static. They need the mask of moving objects of their frame, which arrives a
/// little later, or not at all.
///
/// Thread-safe.
class CloudOutput {
 public:
  CloudOutput(ros::NodeHandle& node, Outputs& outputs, Health& health, const PointsParams& params);

  bool areWanted() const {
    return cloud_.getNumSubscribers() > 0 || static_cloud_.getNumSubscribers() > 0;
  }
  /// Publishes the clouds, or keeps them until their mask or the next frame arrives.
  void prepare(const stereo_msgs::DisparityImageConstPtr& disparity, const StereoPair& pair,
               const MaskInput& masks);
  /// Publishes the clouds that wait for this mask.
  void finish(const sensor_msgs::ImageConstPtr& mask);
  void forget();

 private:
  struct Pending {
    stereo_msgs::DisparityImageConstPtr disparity;
    StereoPair pair;
  };
  void publish(const sensor_msgs::Image* mask);
  void reportMissingMask(bool missing);

  Health& health_;
  const PointsParams params_;
  ros::Publisher cloud_, static_cloud_;
  std::mutex mutex_;
  std::optional<Pending> pending_;
  int missing_masks_ = 0;  // consecutive clouds without a mask
};

}  // namespace predictive_stereo
