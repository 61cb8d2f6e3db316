#include "nodelets/tf_input.h"

#include <utility>

#include "nodelets/message_checks.h"

namespace predictive_stereo {

TfInput::TfInput(ros::NodeHandle node, Health& health, Arrivals& arrivals, Listener listener)
    : health_(health), arrivals_(arrivals), listener_(std::move(listener)) {
  node.setCallbackQueue(&queue_);
  const auto subscribe = [&](const char* name, bool is_static) {
    return node.subscribe<tf2_msgs::TFMessage>(
        name, 100,
        boost::function<void(const Event&)>(
            [this, topic = node.resolveName(name), is_static](const Event& event) {
              add(event, topic, is_static);
            }));
  };
  moving_ = subscribe("/tf", false);
  static_ = subscribe("/tf_static", true);
  spinner_.start();
}

void TfInput::goBackTo(ros::Time stamp) {
  const std::lock_guard<std::mutex> lock(mutex_);
  history_.goBackTo(stamp);
}

void TfInput::add(const Event& event, const std::string& topic, bool is_static) {
  const tf2_msgs::TFMessage::ConstPtr message = event.getConstMessage();
  // Each for itself, because the others of its message may be good.
  for (const geometry_msgs::TransformStamped& transform : message->transforms)
    health_.guard(topic, [&] {
      const std::string& publisher = event.getPublisherName();
      requireTransform(transform, is_static ? ZeroStamp::kLegal : ZeroStamp::kRefused, publisher);
      if (listener_) listener_(transform, publisher, is_static);
      const std::lock_guard<std::mutex> lock(mutex_);
      if (is_static)
        buffer.setTransform(transform, "tf", true);
      else
        history_.add(TfHistory::Transform(message, &transform));  // shares the message's memory
    });
  arrivals_.notify();
}

}  // namespace predictive_stereo
