/// Matches messages from several topics by their stamps.
#pragma once

#include <ros/time.h>

#include <boost/shared_ptr.hpp>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "nodelets/nodelet_params.h"

namespace predictive_stereo {

/// Joins messages whose stamps agree with that of slot 0, as soon as the last of them has arrived.
/// (message_filters' ApproximateTime delays each set until the next frame proves that it is the
/// best one. This is not necessary with a tolerance below half the time between two frames.)
///
/// Not thread-safe.
class StampMatcher {
 public:
  using Message = boost::shared_ptr<const void>;
  using Set = std::vector<Message>;  ///< one message per slot

  /// @param names  of the slots, for descriptions.
  StampMatcher(std::vector<std::string> names, const SyncParams& params);

  /// Adds a message with this stamp to slot `slot`.
  /// @param constant  it belongs to every following set (a calibration that is latched and has no
  ///   stamp).
  /// @returns the sets that it completes, oldest first: at most one, unless it is constant.
  std::vector<Set> add(size_t slot, ros::Time stamp, Message message, bool constant = false);

  /// From now on the first `count` slots make a set; all, until this is called. What waits is
  /// dropped.
  void use(size_t count);

  /// Number of messages of slot 0 that were dropped because a partner was missing.
  size_t unmatched() const { return unmatched_; }

  /// Why there are no sets although every slot gets messages: the slot whose stamps differ most
  /// from those of slot 0, and the difference. Empty: no problem known.
  std::string describeMismatch() const;

 private:
  struct Entry {
    ros::Time stamp;
    Message message;
  };
  struct Slot {
    std::string name;
    std::deque<Entry> waiting;
    Message constant;
  };

  double tolerance() const { return params_.approximate_sync ? params_.sync_tolerance : 0.0; }
  const Entry* nearest(const Slot& slot, ros::Time stamp) const;
  std::optional<Set> setAt(ros::Time stamp) const;
  size_t forgetUpTo(ros::Time stamp);  // returns the number of messages of slot 0

  SyncParams params_;
  std::vector<Slot> slots_;
  size_t used_;  // the first ones
  size_t unmatched_ = 0;
};

}  // namespace predictive_stereo
