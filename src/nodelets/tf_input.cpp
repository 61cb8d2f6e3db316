#include "nodelets/tf_input.h"

#include <algorithm>

namespace predictive_stereo {

TfInput::TfInput(ros::NodeHandle node) {
  using MessagePtr = tf2_msgs::TFMessageConstPtr;
  node.setCallbackQueue(&queue_);
  moving_ = node.subscribe<tf2_msgs::TFMessage>(
      "/tf", 100, boost::function<void(const MessagePtr&)>([this](const MessagePtr& message) {
        add(*message, false);
      }));
  static_ = node.subscribe<tf2_msgs::TFMessage>(
      "/tf_static", 100,
      boost::function<void(const MessagePtr&)>(
          [this](const MessagePtr& message) { add(*message, true); }));
  spinner_.start();
}

void TfInput::goBackTo(ros::Time stamp) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const bool has_later = std::any_of(newest_.begin(), newest_.end(), [&](const auto& newest) {
    return newest.second > stamp + kLeastJump;
  });
  if (has_later) forget();
}

void TfInput::add(const tf2_msgs::TFMessage& message, bool is_static) {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const geometry_msgs::TransformStamped& transform : message.transforms) {
    if (!is_static) {
      ros::Time& newest = newest_[transform.child_frame_id];
      if (transform.header.stamp + kLeastJump < newest) forget();
      newest_[transform.child_frame_id] = transform.header.stamp;
    }
    // tf2 itself logs what it refuses.
    buffer.setTransform(transform, "tf", is_static);
  }
}

void TfInput::forget() {
  buffer.clear();
  newest_.clear();
}

}  // namespace predictive_stereo
