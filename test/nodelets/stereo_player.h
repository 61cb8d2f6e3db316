#pragma once

#include <ros/ros.h>
#include <tf2_msgs/TFMessage.h>

#include <string>

#include "nodelets/stereo_messages.h"
#include "recorder.h"

namespace predictive_stereo {

/// Publishes like a camera driver.
class StereoPlayer {
 public:
  explicit StereoPlayer(const ros::NodeHandle& camera) : node_(camera) {
    left_ = node_.advertise<sensor_msgs::Image>("left/image_rect", 20);
    right_ = node_.advertise<sensor_msgs::Image>("right/image_rect", 20);
    left_info_ = node_.advertise<sensor_msgs::CameraInfo>("left/camera_info", 20);
    right_info_ = node_.advertise<sensor_msgs::CameraInfo>("right/camera_info", 20);
  }

  /// Waits for subscribers; those of one process count once. Waits a moment longer for others that
  /// the first one may have woken.
  bool waitForSubscribers(uint32_t processes = 1) const {
    const bool there = eventually([&] {
      return left_.getNumSubscribers() >= processes && right_.getNumSubscribers() >= processes &&
             left_info_.getNumSubscribers() >= processes &&
             right_info_.getNumSubscribers() >= processes;
    });
    ros::WallDuration(0.5).sleep();
    return there;
  }

  uint32_t subscribers() const {
    return left_.getNumSubscribers() + right_.getNumSubscribers() + left_info_.getNumSubscribers() +
           right_info_.getNumSubscribers();
  }

  void shutDownRight() {
    right_.shutdown();
    right_info_.shutdown();
  }

  void publishLeft(const sensor_msgs::ImageConstPtr& image) { left_.publish(image); }
  void publish(const StereoPair& pair) {
    left_.publish(pair.left);
    right_.publish(pair.right);
    publishInfos(pair);
  }
  void publishInfos(const StereoPair& pair) {
    left_info_.publish(pair.left_info);
    right_info_.publish(pair.right_info);
  }

 private:
  ros::NodeHandle node_;
  ros::Publisher left_, right_, left_info_, right_info_;
};

/// A latched publisher of /tf_static.
class StaticTransform {
 public:
  explicit StaticTransform(const geometry_msgs::TransformStamped& transform) {
    publisher_ = ros::NodeHandle().advertise<tf2_msgs::TFMessage>("/tf_static", 10, true);
    tf2_msgs::TFMessage message;
    message.transforms.push_back(transform);
    publisher_.publish(message);
  }

 private:
  ros::Publisher publisher_;
};

}  // namespace predictive_stereo
