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

/// The tf buffer of a nodelet, filled by a separate thread. It respects remappings of /tf of the
/// nodelet.
///
/// A bag that starts again sends transforms of the past, which tf2 would mix with the old ones. So
/// the buffer is cleared when the first new transform arrives, not with the first new image: images
/// and transforms arrive independently, and transforms of the new pass must not be lost.
class TfInput {
 public:
  /// Called with each transform and the node that published it, from the thread of this object.
  using Listener = std::function<void(const geometry_msgs::TransformStamped&,
                                      const std::string& publisher, bool is_static)>;

  explicit TfInput(ros::NodeHandle node, Listener listener = {});
  ~TfInput() { spinner_.stop(); }

  /// The stamps of images went back to this one: clears the buffer unless tf has gone back already.
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

/// Stamps that go back by less do not mean a new pass of a bag.
const ros::Duration kLeastJump(0.5);

/// Calls `ask` every millisecond until its result is true or timeout_s has passed; returns the last
/// result. (tf2's own wait polls every 10 ms, which is too slow for a frame.)
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
