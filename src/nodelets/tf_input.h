#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <ros/callback_queue.h>
#include <ros/message_event.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <tf2/buffer_core.h>
#include <tf2/exceptions.h>
#include <tf2_msgs/TFMessage.h>

#include <boost/shared_ptr.hpp>
#include <cmath>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>
#include <utility>

#include "nodelets/health.h"
#include "nodelets/message_checks.h"
#include "nodelets/threads.h"
#include "nodelets/transforms.h"

namespace predictive_stereo {

/// Fills a tf buffer with the transforms that move, where time may go back: a bag starts again, or
/// a clock is corrected. tf2 would mix new and old ones, or refuse the new ones, and it cannot
/// forget one frame only. So the last seconds are kept here, and the buffer is filled again from
/// them.
///
/// Stamps of a frame that go back are believed when its next one confirms them, or when the images
/// go back too: then what that frame had before is forgotten. So a bag that starts again replaces
/// frame after frame, while one message out of order, or one publisher with a wrong clock, changes
/// nothing for the other frames.
///
/// Not thread-safe.
class TfHistory {
 public:
  using Transform = boost::shared_ptr<const geometry_msgs::TransformStamped>;

  static constexpr double kKept_s = 10;
  /// Stamps that go back by less do not mean another pass of a bag.
  static constexpr double kLeastJump_s = 0.5;

  /// @param buffer  keeps kKept_s; must outlive this object.
  explicit TfHistory(tf2::BufferCore& buffer) : buffer_(buffer) {}

  /// @throws std::invalid_argument, after the transform was added, if the one before it was alone
  ///   with its stamp: that one is lost.
  void add(const Transform& transform) {
    Child& child = children_[transform->child_frame_id];
    const ros::Time stamp = transform->header.stamp;
    if (!child.isAfter(stamp)) {
      const Transform doubted = std::exchange(child.doubted, nullptr);
      insert(child, transform);
      if (doubted) throwLost(*doubted, stamp);
      return;
    }
    // It confirms a stamp in doubt that it follows.
    const double later_s = child.doubted ? (stamp - child.doubted->header.stamp).toSec() : 0;
    const bool is_second = later_s > 0 && later_s <= kKept_s;
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

  /// The stamps of images went back to this one: forgets what frames have after it.
  void goBackTo(ros::Time stamp) {
    images_ = stamp;
    bool changed = false;
    for (auto& [name, child] : children_) {
      if (!child.isAfter(stamp)) continue;
      child.past.clear();
      if (child.doubted && isNearImages(child.doubted->header.stamp))
        child.past.push_back(child.doubted);
      child.doubted = nullptr;
      changed = true;
    }
    if (changed) fillBuffer();
  }

 private:
  struct Child {
    std::deque<Transform> past;
    Transform doubted;  // its stamp went back

    bool isAfter(ros::Time stamp) const {
      return !past.empty() && (past.back()->header.stamp - stamp).toSec() > kLeastJump_s;
    }
  };

  void insert(Child& child, const Transform& transform) {
    const ros::Time stamp = transform->header.stamp;
    while (!child.past.empty() && (stamp - child.past.front()->header.stamp).toSec() > kKept_s)
      child.past.pop_front();
    child.past.push_back(transform);
    // tf2 logs transforms that it refuses.
    buffer_.setTransform(*transform, "tf", false);
  }

  // Near the first image after they went back: transforms may come before or after it.
  bool isNearImages(ros::Time stamp) const {
    return !images_.isZero() && std::abs((stamp - images_).toSec()) <= kKept_s;
  }

  // Fixed transforms stay in the buffer.
  void fillBuffer() {
    buffer_.clear();
    for (const auto& [name, child] : children_)
      for (const Transform& transform : child.past) buffer_.setTransform(*transform, "tf", false);
  }

  [[noreturn]] static void throwLost(const geometry_msgs::TransformStamped& lost, ros::Time next) {
    throw std::invalid_argument(
        "transform of '" + lost.child_frame_id + "': one stamp was " +
        cv::format("%g", (next - lost.header.stamp).toSec()) +
        " s before the next one, and is ignored. Do two nodes with different clocks publish it?");
  }

  tf2::BufferCore& buffer_;
  std::map<std::string, Child> children_;
  ros::Time images_;  // where they went back to
};

/// Stamp of the newest pose of `frame` relative to `fixed_frame`; zero if tf has none, or if both
/// are fixed to each other.
inline ros::Time newestPose(const tf2::BufferCore& tf, const std::string& fixed_frame,
                            const std::string& frame) {
  try {
    return tf.lookupTransform(withoutSlash(fixed_frame), withoutSlash(frame), ros::Time(0))
        .header.stamp;
  } catch (const tf2::TransformException&) {
    return {};
  }
}

/// Whether tf has such poses, but only before `stamp`.
inline bool isLate(const tf2::BufferCore& tf, const std::string& fixed_frame,
                   const std::string& frame, ros::Time stamp) {
  const ros::Time newest = newestPose(tf, fixed_frame, frame);
  return !newest.isZero() && newest < stamp;
}

/// The cure then.
constexpr char kLateInTf[] =
    "The newest one in tf is older than the image: raise transform_timeout, or publish it more "
    "often; or has its publisher stopped, or another clock?";

/// The tf buffer of a nodelet, filled by a separate thread. It respects remappings of /tf of the
/// nodelet. A transform that is refused is a problem of the topic.
class TfInput {
 public:
  /// Called with each transform and the node that published it, from the thread of this object.
  using Listener = std::function<void(const geometry_msgs::TransformStamped&,
                                      const std::string& publisher, bool is_static)>;

  /// @param arrivals  notified of each message.
  TfInput(ros::NodeHandle node, Health& health, Arrivals& arrivals, Listener listener = {})
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
  ~TfInput() { spinner_.stop(); }

  /// See TfHistory: transforms that have gone back already, before the images, are kept.
  void goBackTo(ros::Time stamp) {
    const std::lock_guard<std::mutex> lock(mutex_);
    history_.goBackTo(stamp);
  }

  tf2::BufferCore buffer{ros::Duration(TfHistory::kKept_s)};

 private:
  using Event = ros::MessageEvent<const tf2_msgs::TFMessage>;

  void add(const Event& event, const std::string& topic, bool is_static) {
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

  Health& health_;
  Arrivals& arrivals_;
  const Listener listener_;
  std::mutex mutex_;
  TfHistory history_{buffer};
  ros::CallbackQueue queue_;
  ros::AsyncSpinner spinner_{1, &queue_};
  ros::Subscriber moving_, static_;
};

}  // namespace predictive_stereo
