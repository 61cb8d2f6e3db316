#include "nodelets/tf_input.h"

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "nodelets/message_checks.h"

namespace predictive_stereo {
namespace {

ros::Time stampOf(const TfHistory::Transform& transform) { return transform->header.stamp; }

bool isBefore(ros::Time stamp, ros::Time other) {
  return (other - stamp).toSec() > TfHistory::kLeastJump_s;
}

// Whether a stamp follows that of a message which is in doubt.
bool confirms(ros::Time stamp, ros::Time doubted) {
  const double later_s = (stamp - doubted).toSec();
  return later_s > 0 && later_s <= TfHistory::kKept_s;
}

}  // namespace

void TfHistory::add(const Transform& transform) {
  Child& child = children_[transform->child_frame_id];
  const ros::Time stamp = stampOf(transform);
  if (child.past.empty() || !isBefore(stamp, stampOf(child.past.back()))) {
    const Transform doubted = std::exchange(child.doubted, nullptr);
    insert(child, transform);
    if (!doubted) return;
    std::ostringstream text;
    text
        << "transform of '" << transform->child_frame_id << "': one stamp was "
        << (stamp - stampOf(doubted)).toSec()
        << " s before the next one, and is ignored. Do two nodes with different clocks publish it?";
    throw std::invalid_argument(text.str());
  }
  const bool is_second = child.doubted && confirms(stamp, stampOf(child.doubted));
  if (!is_second && !isNearImages(stamp)) {
    child.doubted = transform;
    return;
  }
  child.past.clear();
  if (is_second) child.past.push_back(child.doubted);
  child.past.push_back(transform);
  child.doubted = nullptr;
  fillBuffer();
}

void TfHistory::goBackTo(ros::Time stamp) {
  images_ = stamp;
  bool changed = false;
  for (auto& [name, child] : children_) {
    if (child.past.empty() || !isBefore(stamp, stampOf(child.past.back()))) continue;
    child.past.clear();
    if (child.doubted && isNearImages(stampOf(child.doubted))) child.past.push_back(child.doubted);
    child.doubted = nullptr;
    changed = true;
  }
  if (changed) fillBuffer();
}

void TfHistory::insert(Child& child, const Transform& transform) {
  while (!child.past.empty() &&
         (stampOf(transform) - stampOf(child.past.front())).toSec() > kKept_s)
    child.past.pop_front();
  child.past.push_back(transform);
  // tf2 logs transforms that it refuses.
  buffer_.setTransform(*transform, "tf", false);
}

// Near the first image after they went back: transforms may come before or after it.
bool TfHistory::isNearImages(ros::Time stamp) const {
  return !images_.isZero() && std::abs((stamp - images_).toSec()) <= kKept_s;
}

// Fixed transforms stay in the buffer.
void TfHistory::fillBuffer() {
  buffer_.clear();
  for (const auto& [name, child] : children_)
    for (const Transform& transform : child.past) buffer_.setTransform(*transform, "tf", false);
}

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
