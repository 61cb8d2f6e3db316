#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include "nodelets/message_checks.h"

namespace predictive_stereo {

/// Messages of a bag that the nodelets would refuse: tools go on without them, as nodelets do.
class RefusedMessages {
 public:
  /// @param tell  called with the first objection of each topic.
  explicit RefusedMessages(std::function<void(const std::string&)> tell) : tell_(std::move(tell)) {}

  bool has(const std::string& topic, ros::Time stamp, ZeroStamp zero) {
    return isRefused(topic, [&] { requireStamp(stamp, zero); });
  }
  bool has(const std::string& topic, const geometry_msgs::TransformStamped& transform,
           bool is_static) {
    const ZeroStamp zero = is_static ? ZeroStamp::kLegal : ZeroStamp::kRefused;
    return isRefused(topic, [&] { requireTransform(transform, zero, "the bag"); });
  }

  /// Their number, for each topic that has some.
  const std::map<std::string, size_t>& counts() const { return counts_; }

 private:
  template <class Check>
  bool isRefused(const std::string& topic, const Check& check) {
    try {
      check();
    } catch (const std::invalid_argument& error) {
      if (counts_[topic]++ == 0) tell_(topic + ": " + error.what());
      return true;
    }
    return false;
  }

  std::function<void(const std::string&)> tell_;
  std::map<std::string, size_t> counts_;
};

}  // namespace predictive_stereo
