#include "nodelets/cloud_output.h"

#include <sensor_msgs/PointCloud2.h>

#include <exception>

#include "nodelets/disparity_views.h"

namespace predictive_stereo {

CloudOutput::CloudOutput(ros::NodeHandle& node, Outputs& outputs, Health& health,
                         const PointsParams& params)
    : health_(health),
      params_(params),
      cloud_(outputs.advertise<sensor_msgs::PointCloud2>(node, "points2", 5)),
      static_cloud_(outputs.advertise<sensor_msgs::PointCloud2>(node, "points2_static", 5)) {}

void CloudOutput::prepare(const stereo_msgs::DisparityImageConstPtr& disparity,
                          const StereoPair& pair, const MaskInput& masks) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (pending_) publish(nullptr);
  if (!areWanted()) return;
  pending_ = Pending{disparity, pair};
  const sensor_msgs::ImageConstPtr mask = masks.at(disparity->header.stamp);
  if (mask || !masks.isPublished()) publish(mask.get());
}

void CloudOutput::finish(const sensor_msgs::ImageConstPtr& mask) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (pending_ && pending_->disparity->header.stamp == mask->header.stamp) publish(mask.get());
}

void CloudOutput::forget() {
  const std::lock_guard<std::mutex> lock(mutex_);
  pending_.reset();
  missing_masks_ = 0;
}

void CloudOutput::publish(const sensor_msgs::Image* mask) {
  try {
    const StereoRig rig = stereoRig(pending_->pair);
    const auto cloud = [&](MovingPoints moving) {
      return pointCloud(*pending_->disparity, rig, *pending_->pair.left, mask, params_, moving);
    };
    if (cloud_.getNumSubscribers() > 0) cloud_.publish(cloud(MovingPoints::kTinted));
    if (static_cloud_.getNumSubscribers() > 0) {
      // No cloud is better for a planner than a cloud with possible moving objects.
      if (mask) static_cloud_.publish(cloud(MovingPoints::kLeftOut));
      reportMissingMask(!mask);
    }
  } catch (const std::exception& e) {
    health_.problem("points2", Health::Severity::kDegraded, e.what());
  }
  pending_.reset();
}

void CloudOutput::reportMissingMask(bool missing) {
  constexpr int kTellMissingMasks = 10;
  missing_masks_ = missing ? missing_masks_ + 1 : 0;
  if (!missing) health_.solved("points2_static");
  if (missing_masks_ == kTellMissingMasks)
    health_.problem("points2_static", Health::Severity::kDegraded,
                    "points2_static is not published, as the mask of moving objects is missing: "
                    "run the MovingObjects nodelet (launch argument moving_objects:=true)");
}

}  // namespace predictive_stereo
