#pragma once

#include <ros/node_handle.h>
#include <tf2/buffer_core.h>
#include <tf2_ros/transform_listener.h>

#include <chrono>
#include <thread>

namespace predictive_stereo {

/// What a nodelet knows of tf, kept up to date by a thread of its own. Remappings of /tf that are
/// given to the nodelet hold.
struct TfInput {
  explicit TfInput(const ros::NodeHandle& node) : listener(buffer, node) {}

  tf2::BufferCore buffer{ros::Duration(30.0)};
  tf2_ros::TransformListener listener;
};

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
