#pragma once

#include <ros/time.h>

#include <algorithm>
#include <boost/shared_ptr.hpp>
#include <deque>
#include <iterator>
#include <mutex>
#include <vector>

namespace predictive_stereo {

/// Messages (with a header) of one topic: the last ones. Thread-safe.
template <class Message>
class MessageHistory {
 public:
  using ConstPtr = boost::shared_ptr<const Message>;

  /// @param most  keeps so many at most, and only those of the last three seconds: a frame needs
  ///   messages since the previous frame.
  explicit MessageHistory(size_t most = 10000) : most_(most) {}

  /// Out of order is allowed, but stamps that went back by more than half a second are those of
  /// another pass: they replace all others.
  void add(const ConstPtr& message) {
    const std::lock_guard<std::mutex> lock(mutex_);
    dropIfBefore(message->header.stamp);
    messages_.insert(std::upper_bound(messages_.begin(), messages_.end(), message,
                                      [](const ConstPtr& a, const ConstPtr& b) {
                                        return a->header.stamp < b->header.stamp;
                                      }),
                     message);
    while (messages_.size() > most_ ||
           messages_.back()->header.stamp - messages_.front()->header.stamp >
               ros::Duration(kKept_s))
      messages_.pop_front();
  }
  /// The stamps of images went back to this one: drops messages of the previous pass.
  void goBackTo(ros::Time stamp) {
    const std::lock_guard<std::mutex> lock(mutex_);
    dropIfBefore(stamp);
  }
  void clear() {
    const std::lock_guard<std::mutex> lock(mutex_);
    messages_.clear();
  }
  /// nullptr: none yet.
  ConstPtr last() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return messages_.empty() ? nullptr : messages_.back();
  }
  /// The first message that is not older than `stamp`; nullptr: none yet.
  ConstPtr at(ros::Time stamp) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto message = firstFrom(stamp);
    return message == messages_.end() ? nullptr : *message;
  }
  /// The message with this stamp; nullptr: none.
  ConstPtr of(ros::Time stamp) const {
    const ConstPtr found = at(stamp);
    return found && found->header.stamp == stamp ? found : nullptr;
  }
  /// Those of an interval, and its neighbours: from the last that is not newer than `begin`, to the
  /// first that is not older than `end`; as far as there are any.
  std::vector<ConstPtr> around(ros::Time begin, ros::Time end) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    auto first = firstFrom(begin), last = firstFrom(end);
    if (first != messages_.begin() && (first == messages_.end() || (*first)->header.stamp != begin))
      --first;
    if (last != messages_.end()) ++last;
    return {first, last};
  }
  /// The last message that is older than `stamp`; nullptr: none.
  ConstPtr before(ros::Time stamp) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto message = firstFrom(stamp);
    return message == messages_.begin() ? nullptr : *std::prev(message);
  }

 private:
  static constexpr double kKept_s = 3.0, kLeastJump_s = 0.5;

  void dropIfBefore(ros::Time stamp) {
    if (!messages_.empty() && (messages_.back()->header.stamp - stamp).toSec() > kLeastJump_s)
      messages_.clear();
  }

  // add() keeps the stamps in order.
  auto firstFrom(ros::Time stamp) const {
    return std::lower_bound(
        messages_.begin(), messages_.end(), stamp,
        [](const ConstPtr& message, ros::Time time) { return message->header.stamp < time; });
  }

  const size_t most_;
  mutable std::mutex mutex_;
  std::deque<ConstPtr> messages_;
};

}  // namespace predictive_stereo
