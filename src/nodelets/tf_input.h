#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <ros/callback_queue.h>
#include <ros/message_event.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <tf2/buffer_core.h>
#include <tf2_msgs/TFMessage.h>

#include <boost/shared_ptr.hpp>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <string>

#include "nodelets/health.h"
#include "nodelets/threads.h"

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
  void add(const Transform& transform);

  /// The stamps of images went back to this one: forgets what frames have after it.
  void goBackTo(ros::Time stamp);

 private:
  struct Child {
    std::deque<Transform> past;
    Transform doubted;  // its stamp went back
  };

  void insert(Child& child, const Transform& transform);
  bool isNearImages(ros::Time stamp) const;
  void fillBuffer();

  tf2::BufferCore& buffer_;
  std::map<std::string, Child> children_;
  ros::Time images_;  // where they went back to
};

/// The tf buffer of a nodelet, filled by a separate thread. It respects remappings of /tf of the
/// nodelet. A transform that is refused is a problem of the topic.
class TfInput {
 public:
  /// Called with each transform and the node that published it, from the thread of this object.
  using Listener = std::function<void(const geometry_msgs::TransformStamped&,
                                      const std::string& publisher, bool is_static)>;

  /// @param arrivals  notified of each message.
  TfInput(ros::NodeHandle node, Health& health, Arrivals& arrivals, Listener listener = {});
  ~TfInput() { spinner_.stop(); }

  /// See TfHistory: transforms that have gone back already, before the images, are kept.
  void goBackTo(ros::Time stamp);

  tf2::BufferCore buffer{ros::Duration(TfHistory::kKept_s)};

 private:
  using Event = ros::MessageEvent<const tf2_msgs::TFMessage>;

  void add(const Event& event, const std::string& topic, bool is_static);

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
