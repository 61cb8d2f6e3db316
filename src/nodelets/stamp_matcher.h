/// Gathers the messages of one instant from several topics.
#pragma once

#include <ros/time.h>

#include <boost/shared_ptr.hpp>
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "nodelets/nodelet_params.h"

namespace predictive_stereo {

/// Messages that roscpp keeps of a topic until they are taken. What does not fit in is thrown away
/// without a word, so there is more room than a nodelet needs: what is too much is then dropped
/// where it is counted, by StampMatcher and LatestWorker.
constexpr uint32_t kRoscppQueue = 64;

/// Joins messages whose stamps agree with that of slot 0, as soon as the last of them is there.
/// (message_filters' ApproximateTime holds each set back until the next frame proves it to be the
/// best; with a tolerance below half the frame time there is nothing to prove.)
///
/// Not thread-safe.
class StampMatcher {
 public:
  using Message = boost::shared_ptr<const void>;
  using Set = std::vector<Message>;  ///< one message a slot

  /// @param names  of the slots, for descriptions.
  StampMatcher(std::vector<std::string> names, const SyncParams& params);

  /// A message with this stamp came for slot `slot`.
  /// @param constant  it belongs to every set from now on (a calibration that is latched and has no
  ///   stamp).
  /// @returns the sets that it completes, oldest first: one at most, unless it is constant.
  std::vector<Set> add(size_t slot, ros::Time stamp, Message message, bool constant = false);

  void clear();

  /// Messages of slot 0 that were given up because a partner was missing.
  size_t unmatched() const { return unmatched_; }

  /// Why no sets come out although every slot gets messages: the slot whose stamps differ most from
  /// those of slot 0, and by how much. Empty where nothing is known to be wrong.
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
  bool collectSet(ros::Time stamp, Set& set) const;
  size_t forgetUpTo(ros::Time stamp);  // returns how many of slot 0 went

  SyncParams params_;
  std::vector<Slot> slots_;
  size_t unmatched_ = 0;
};

}  // namespace predictive_stereo
