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
    return refuses(topic, [&] { requireStamp(stamp, zero); });
  }
  bool has(const std::string& topic, const geometry_msgs::TransformStamped& transform,
           bool is_static) {
    const ZeroStamp zero = is_static ? ZeroStamp::kLegal : ZeroStamp::kRefused;
    return refuses(topic, [&] { requireTransform(transform, zero, "the bag"); });
  }
  /// Whether `use` of a message throws std::invalid_argument.
  template <class Use>
  bool refuses(const std::string& topic, const Use& use) {
    try {
      use();
    } catch (const std::invalid_argument& error) {
      if (first_.empty()) first_ = topic + ": " + error.what();
      if (counts_[topic]++ == 0) tell_(topic + ": " + error.what());
      return true;
    }
    return false;
  }

  /// The first objection of all; empty: none.
  const std::string& first() const { return first_; }
  /// Their number, for each topic that has some.
  const std::map<std::string, size_t>& counts() const { return counts_; }

 private:
  std::function<void(const std::string&)> tell_;
  std::map<std::string, size_t> counts_;
  std::string first_;
};

}  // namespace predictive_stereo
