#pragma once

#include <ros/callback_queue.h>
#include <ros/message_event.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <tf2/buffer_core.h>
#include <tf2_msgs/TFMessage.h>

#include <chrono>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>

namespace predictive_stereo {

/// What a nodelet knows of tf, kept up to date by a thread of its own. Remappings of /tf that are
/// given to the nodelet hold.
///
/// A bag that starts again sends transforms of the past, which tf2 would mix with those it has.
/// They are forgotten when the first of the new ones comes, not with the first image: images and tf
/// come on different ways, and what is already known of the new pass must not be lost.
class TfInput {
 public:
  /// Called with each transform and the node that published it, by the thread of this.
  using Listener = std::function<void(const geometry_msgs::TransformStamped&,
                                      const std::string& publisher, bool is_static)>;

  explicit TfInput(ros::NodeHandle node, Listener listener = {});
  ~TfInput() { spinner_.stop(); }

  /// Images went back to this stamp: forgets what is of a later pass, if tf has not gone back yet.
  void goBackTo(ros::Time stamp);

  tf2::BufferCore buffer{ros::Duration(10.0)};

 private:
  using Event = ros::MessageEvent<const tf2_msgs::TFMessage>;

  void add(const Event& event, bool is_static);
  void forget();

  const Listener listener_;
  std::mutex mutex_;
  std::map<std::string, ros::Time> newest_;  // of each child frame
  ros::CallbackQueue queue_;
  ros::AsyncSpinner spinner_{1, &queue_};
  ros::Subscriber moving_, static_;
};

/// Stamps that go back by less are not those of another pass.
const ros::Duration kLeastJump(0.5);

/// Calls `ask` until what it returns is true, for timeout_s at most. Polls each millisecond: tf2's
/// own waiting looks every 10 ms, which a frame cannot spare.
template <class Ask>
auto waitFor(double timeout_s, Ask&& ask) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(timeout_s);
  auto answer = ask();
  while (!answer && ros::ok() && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    answer = ask();
  }
  return answer;
}

}  // namespace predictive_stereo
