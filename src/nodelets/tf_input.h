#pragma once

#include <ros/callback_queue.h>
#include <ros/message_event.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <tf2/buffer_core.h>
#include <tf2_msgs/TFMessage.h>

#include <functional>
#include <mutex>
#include <string>

#include "nodelets/arrivals.h"
#include "nodelets/health.h"
#include "nodelets/tf_history.h"

namespace predictive_stereo {

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
