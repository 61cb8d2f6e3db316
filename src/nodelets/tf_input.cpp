#include "nodelets/tf_input.h"

#include <algorithm>
#include <utility>

namespace predictive_stereo {

TfInput::TfInput(ros::NodeHandle node, Listener listener) : listener_(std::move(listener)) {
  node.setCallbackQueue(&queue_);
  const auto subscribe = [&](const char* topic, bool is_static) {
    return node.subscribe<tf2_msgs::TFMessage>(
        topic, 100, boost::function<void(const Event&)>([this, is_static](const Event& event) {
          add(event, is_static);
        }));
  };
  moving_ = subscribe("/tf", false);
  static_ = subscribe("/tf_static", true);
  spinner_.start();
}

void TfInput::goBackTo(ros::Time stamp) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const bool has_later = std::any_of(newest_.begin(), newest_.end(), [&](const auto& newest) {
    return newest.second > stamp + kLeastJump;
  });
  if (has_later) forget();
}

void TfInput::add(const Event& event, bool is_static) {
  const tf2_msgs::TFMessage& message = *event.getConstMessage();
  if (listener_)
    for (const geometry_msgs::TransformStamped& transform : message.transforms)
      listener_(transform, event.getPublisherName(), is_static);
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const geometry_msgs::TransformStamped& transform : message.transforms) {
    if (!is_static) {
      ros::Time& newest = newest_[transform.child_frame_id];
      if (transform.header.stamp + kLeastJump < newest) forget();
      newest_[transform.child_frame_id] = transform.header.stamp;
    }
    // tf2 logs transforms that it refuses.
    buffer.setTransform(transform, "tf", is_static);
  }
}

void TfInput::forget() {
  buffer.clear();
  newest_.clear();
}

}  // namespace predictive_stereo
