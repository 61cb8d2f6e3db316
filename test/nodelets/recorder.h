#pragma once

#include <diagnostic_msgs/DiagnosticArray.h>
#include <ros/ros.h>
#include <stereo_msgs/DisparityImage.h>

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace predictive_stereo {

/// Waits until a condition holds that other threads make true; returns whether it does.
inline bool eventually(const std::function<bool()>& condition, double timeout_s = 30) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(timeout_s);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

/// Records the messages of a topic.
template <class Message>
class Recorder {
 public:
  using ConstPtr = boost::shared_ptr<const Message>;

  Recorder(ros::NodeHandle node, const std::string& topic)
      : subscriber_(node.subscribe<Message>(topic, 100, [this](const ConstPtr& message) {
          const std::lock_guard<std::mutex> lock(mutex_);
          messages_.push_back(message);
        })) {}

  size_t count() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return messages_.size();
  }
  std::vector<ConstPtr> messages() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return messages_;
  }
  ConstPtr last() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return messages_.empty() ? nullptr : messages_.back();
  }
  /// The message with this stamp; nullptr: not received.
  ConstPtr at(ros::Time stamp) const {
    for (const ConstPtr& message : messages())
      if (message->header.stamp == stamp) return message;
    return nullptr;
  }
  void clear() {
    const std::lock_guard<std::mutex> lock(mutex_);
    messages_.clear();
  }
  void stop() { subscriber_.shutdown(); }
  bool connected() const { return subscriber_.getNumPublishers() > 0; }

 private:
  mutable std::mutex mutex_;
  std::vector<ConstPtr> messages_;
  ros::Subscriber subscriber_;
};

using DisparityRecorder = Recorder<stereo_msgs::DisparityImage>;

/// Records the nodelets' diagnostics.
class DiagnosticsRecorder {
 public:
  explicit DiagnosticsRecorder(ros::NodeHandle node)
      : subscriber_(node.subscribe<diagnostic_msgs::DiagnosticArray>(
            "/diagnostics", 100, [this](const diagnostic_msgs::DiagnosticArrayConstPtr& array) {
              const std::lock_guard<std::mutex> lock(mutex_);
              for (const auto& status : array->status) status_[status.name] = status;
            })) {}

  /// The last status whose name contains `part`.
  diagnostic_msgs::DiagnosticStatus of(const std::string& part) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (const auto& status : status_)
      if (status.first.find(part) != std::string::npos) return status.second;
    return {};
  }
  bool says(const std::string& part, const std::string& text) const {
    return of(part).message.find(text) != std::string::npos;
  }
  std::string value(const std::string& part, const std::string& key) const {
    for (const auto& pair : of(part).values)
      if (pair.key == key) return pair.value;
    return "";
  }

 private:
  mutable std::mutex mutex_;
  std::map<std::string, diagnostic_msgs::DiagnosticStatus> status_;
  ros::Subscriber subscriber_;
};

}  // namespace predictive_stereo
