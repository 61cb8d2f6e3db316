#pragma once

#include <ros/node_handle.h>
#include <sensor_msgs/Image.h>

#include <functional>
#include <mutex>
#include <optional>
#include <utility>

#include "nodelets/health.h"
#include "nodelets/mask_input.h"
#include "nodelets/output_topics.h"

namespace predictive_stereo {

/// The clouds of Disparity, points2 and points2_static. They need the mask of moving objects of
/// their frame, which arrives a little later, or not at all.
///
/// Thread-safe.
class CloudOutput {
 public:
  /// @param changed  see Outputs.
  CloudOutput(const ros::NodeHandle& node, std::function<void()> changed, Health& health,
              const PointsParams& params)
      : health_(health), params_(params), outputs_(node, std::move(changed)) {
    visitCloudOutputs(outputs_);
  }

  bool wanted() const { return outputs_.wanted(); }
  /// The clouds of this frame may wait until its mask or the next frame arrives.
  void publish(const DisparityMessages& messages, const MaskInput& masks) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (pending_) publishPending(nullptr);
    if (!wanted()) return;
    pending_ = CloudSource{messages.disparity, messages.left, messages.rig, params_, nullptr};
    const sensor_msgs::ImageConstPtr mask = masks.at(messages.left->header.stamp);
    if (mask || !masks.isPublished()) publishPending(mask);
  }

  /// Publishes the clouds that wait for this mask.
  void finish(const sensor_msgs::ImageConstPtr& mask) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (pending_ && pending_->disparity->header.stamp == mask->header.stamp) publishPending(mask);
  }

  void forget() {
    const std::lock_guard<std::mutex> lock(mutex_);
    pending_.reset();
    missing_masks_ = 0;
  }

 private:
  void publishPending(const sensor_msgs::ImageConstPtr& mask) {
    health_.guard("points2", [&] {
      pending_->mask = mask;
      outputs_.publish(*pending_);
      if (outputs_.wanted("points2_static")) reportMissingMask(!mask);
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
  Outputs<CloudSource> outputs_;
  std::mutex mutex_;
  std::optional<CloudSource> pending_;
  int missing_masks_ = 0;  // consecutive clouds without a mask
};

}  // namespace predictive_stereo
