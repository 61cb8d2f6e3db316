#pragma once

#include <image_transport/image_transport.h>
#include <ros/node_handle.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/PointCloud2.h>
#include <stereo_msgs/DisparityImage.h>

#include <mutex>
#include <optional>

#include "nodelets/disparity_processor.h"
#include "nodelets/health.h"
#include "nodelets/mask_input.h"
#include "nodelets/nodelet_params.h"
#include "nodelets/outputs.h"
#include "nodelets/stereo_messages.h"
#include "nodelets/views.h"

namespace predictive_stereo {

/// Disparity's topics of views.h, made while they have subscribers. The clouds, points2 and
/// points2_static, need the mask of moving objects of their frame, which arrives a little later, or
/// not at all.
///
/// Thread-safe.
class ViewOutput {
 public:
  ViewOutput(ros::NodeHandle& node, Outputs& outputs, Health& health, const PointsParams& params)
      : health_(health),
        params_(params),
        disparity_(outputs.advertise<sensor_msgs::Image>(node, "disparity/image", 5)),
        standard_deviation_(
            outputs.advertise<sensor_msgs::Image>(node, "disparity/standard_deviation", 5)),
        depth_(outputs.advertise<sensor_msgs::Image>(node, "depth/image_rect", 5)),
        depth_info_(outputs.advertise<sensor_msgs::CameraInfo>(node, "depth/camera_info", 5)),
        cloud_(outputs.advertise<sensor_msgs::PointCloud2>(node, "points2", 5)),
        static_cloud_(outputs.advertise<sensor_msgs::PointCloud2>(node, "points2_static", 5)),
        colour_(outputs.advertiseImage(node, "disparity/color", 5)) {}

  bool needsMask() const {
    return cloud_.getNumSubscribers() > 0 || static_cloud_.getNumSubscribers() > 0;
  }
  /// Publishes all but the clouds, which may wait until their mask or the next frame arrives.
  void publish(const DisparityMessages& messages, const StereoPair& pair, const MaskInput& masks) {
    const stereo_msgs::DisparityImageConstPtr disparity = messages.disparity;
    if (disparity_.getNumSubscribers() > 0) disparity_.publish(innerImage(disparity));
    if (colour_.getNumSubscribers() > 0) colour_.publish(colourImage(*disparity));
    if (standard_deviation_.getNumSubscribers() > 0)
      standard_deviation_.publish(standardDeviationImage(*messages.disparity_variance));
    if (depth_.getNumSubscribers() > 0) depth_.publish(depthImage(*disparity));
    if (depth_info_.getNumSubscribers() > 0) depth_info_.publish(depthCameraInfo(pair));

    const std::lock_guard<std::mutex> lock(mutex_);
    if (pending_) publishClouds(nullptr);
    if (!needsMask()) return;
    pending_ = Pending{disparity, pair};
    const sensor_msgs::ImageConstPtr mask = masks.at(disparity->header.stamp);
    if (mask || !masks.isPublished()) publishClouds(mask.get());
  }

  /// Publishes the clouds that wait for this mask.
  void finishClouds(const sensor_msgs::ImageConstPtr& mask) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (pending_ && pending_->disparity->header.stamp == mask->header.stamp)
      publishClouds(mask.get());
  }

  void forget() {
    const std::lock_guard<std::mutex> lock(mutex_);
    pending_.reset();
    missing_masks_ = 0;
  }

 private:
  struct Pending {
    stereo_msgs::DisparityImageConstPtr disparity;
    StereoPair pair;
  };
  void publishClouds(const sensor_msgs::Image* mask) {
    health_.guard("points2", [&] {
      const StereoRig rig = stereoRig(pending_->pair);
      const auto cloud = [&](MovingPoints moving) {
        return pointCloud(*pending_->disparity, rig, *pending_->pair.left, mask, params_, moving);
      };
      if (cloud_.getNumSubscribers() > 0) cloud_.publish(cloud(MovingPoints::kTinted));
      if (static_cloud_.getNumSubscribers() == 0) return;
      // No cloud is better for a planner than a cloud with possible moving objects.
      if (mask) static_cloud_.publish(cloud(MovingPoints::kLeftOut));
      reportMissingMask(!mask);
    });
    pending_.reset();
  }

  void reportMissingMask(bool missing) {
    constexpr int kTellMissingMasks = 10;
    missing_masks_ = missing ? missing_masks_ + 1 : 0;
    if (!missing) health_.solved("points2_static");
    if (missing_masks_ == kTellMissingMasks)
      health_.problem("points2_static",
                      "points2_static is not published, as the mask of moving objects is missing: "
                      "run the MovingObjects nodelet (launch argument moving_objects:=true)");
  }

  Health& health_;
  const PointsParams params_;
  ros::Publisher disparity_, standard_deviation_, depth_, depth_info_, cloud_, static_cloud_;
  image_transport::Publisher colour_;
  std::mutex mutex_;
  std::optional<Pending> pending_;
  int missing_masks_ = 0;  // consecutive clouds without a mask
};

}  // namespace predictive_stereo
