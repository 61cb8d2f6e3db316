#pragma once

#include <ros/node_handle.h>

#include <atomic>
#include <mutex>
#include <string>
#include <utility>

#include "nodelets/callbacks.h"
#include "nodelets/message_checks.h"
#include "nodelets/message_history.h"
#include "nodelets/threads.h"

namespace predictive_stereo {

/// The last messages on a topic of another node, which a frame may wait for.
template <class Message>
class MessageInput {
 public:
  using ConstPtr = boost::shared_ptr<const Message>;

  /// @param most  see MessageHistory.
  /// @param received  called with each message, from the node handle's callback queue; may throw.
  MessageInput(const ros::NodeHandle& node, Health& health, Arrivals& arrivals, size_t most = 10000,
               Receiver<Message> received = {})
      : health_(health),
        arrivals_(arrivals),
        node_(node),
        received_(std::move(received)),
        history_(most) {}

  /// Subscribes to this topic instead of the previous one; empty: to none, and forgets what it has.
  /// After this has returned, nothing of the previous one is received. Not thread-safe.
  void listenTo(const std::string& topic, uint32_t queue = kRoscppQueue) {
    if (topic == topic_) return;
    topic_ = topic;
    silent_ = false;
    ros::Subscriber next;
    if (!topic.empty())
      next = subscribe<Message>(node_, health_, topic, queue,
                                [this](const ConstPtr& message) { add(message); });
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      std::swap(next, subscriber_);
    }
    next.shutdown();  // without the lock: it waits for callbacks, and these may take the lock
    if (topic.empty()) history_.clear();
  }

  bool isPublished() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return subscriber_.getNumPublishers() > 0;
  }
  /// Whether it is worth to wait for a message.
  bool isExpected() const { return isPublished() && !silent_; }
  /// A message was waited for in vain: none is expected until the next one arrives.
  void expectNone() { silent_ = true; }
  /// Waits for the message of this stamp; nullptr: it did not come. After a timeout it does not
  /// wait again until another message has arrived.
  ConstPtr waitFor(ros::Time stamp, double timeout_s) {
    const bool expected = isExpected();
    const ConstPtr message =
        arrivals_.waitFor(expected ? timeout_s : 0.0, [&] { return history_.of(stamp); });
    if (expected && !message) expectNone();
    return message;
  }

  MessageHistory<Message>& history() { return history_; }
  const MessageHistory<Message>& history() const { return history_; }

 private:
  void add(const ConstPtr& message) {
    requireUsable(*message);
    history_.add(message);
    silent_ = false;
    arrivals_.notify();
    if (received_) received_(message);
  }

  Health& health_;
  Arrivals& arrivals_;
  ros::NodeHandle node_;
  const Receiver<Message> received_;
  MessageHistory<Message> history_;
  std::string topic_;
  std::atomic<bool> silent_{false};
  mutable std::mutex mutex_;
  ros::Subscriber subscriber_;
};

}  // namespace predictive_stereo
