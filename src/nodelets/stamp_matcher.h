/// Matches messages from several topics by their stamps.
#pragma once

#include <ros/time.h>

#include <algorithm>
#include <boost/shared_ptr.hpp>
#include <cmath>
#include <deque>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>
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
  StampMatcher(std::vector<std::string> names, const SyncParams& params)
      : params_(params), used_(names.size()) {
    validate(params);
    for (std::string& name : names) slots_.push_back({std::move(name), {}, {}});
  }

  /// Adds a message with this stamp to slot `index`.
  /// @param constant  it belongs to every following set (a calibration that is latched and has no
  ///   stamp).
  /// @returns the sets that it completes, oldest first: at most one, unless it is constant.
  std::vector<Set> add(size_t index, ros::Time stamp, Message message, bool constant = false) {
    Slot& slot = slots_[index];
    if (constant) {
      slot.constant = std::move(message);
    } else {
      slot.constant = nullptr;  // stamped messages replace a constant one
      slot.waiting.push_back({stamp, std::move(message)});
      if (slot.waiting.size() > static_cast<size_t>(params_.queue_size)) {
        slot.waiting.pop_front();
        if (index == 0) ++unmatched_;
      }
    }

    std::vector<Set> sets;
    ros::Time last;
    for (const Entry& reference : slots_[0].waiting)
      if (std::optional<Set> set = setAt(reference.stamp)) {
        sets.push_back(std::move(*set));
        last = reference.stamp;
      }
    if (!sets.empty()) unmatched_ += forgetUpTo(last) - sets.size();
    return sets;
  }

  /// From now on the first `count` slots make a set; all, until this is called. What waits is
  /// dropped.
  void use(size_t count) {
    for (Slot& slot : slots_) slot.waiting.clear();
    used_ = count;
  }

  /// Number of messages of slot 0 that were dropped because a partner was missing.
  size_t unmatched() const { return unmatched_; }

  /// Why there are no sets although every slot gets messages: the slot whose stamps differ most
  /// from those of slot 0, and the difference. Empty: no problem known.
  std::string describeMismatch() const {
    double worst_s = tolerance();
    const Slot* worst = nullptr;
    for (const Slot& slot : slots_) {
      if (slot.constant || slot.waiting.empty()) continue;
      double closest_s = std::numeric_limits<double>::infinity();
      for (const Entry& reference : slots_[0].waiting)
        closest_s = std::min(closest_s,
                             difference_s(nearest(slot, reference.stamp)->stamp, reference.stamp));
      if (!std::isfinite(closest_s) || closest_s <= worst_s) continue;
      worst_s = closest_s;
      worst = &slot;
    }
    if (!worst) return "";
    const auto &left = slots_[0].waiting, &others = worst->waiting;
    const bool apart =
        others.back().stamp < left.front().stamp || left.back().stamp < others.front().stamp;
    return "the stamps of " + worst->name + " differ from those of " + slots_[0].name +
           cv::format(" by %g ms or more, but ", worst_s * 1e3) +
           (apart && left.size() > 1
                ? "the queues hold less: synchronise the clocks of both publishers, or raise "
                  "queue_size if one sends later than the other"
            : params_.approximate_sync
                ? cv::format("sync_tolerance allows %g ms: set sync_tolerance above the "
                             "difference, or synchronise the cameras",
                             params_.sync_tolerance * 1e3)
                : "approximate_sync is false: set approximate_sync to true");
  }

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

  static double difference_s(ros::Time a, ros::Time b) { return std::abs((a - b).toSec()); }
  double tolerance() const { return params_.approximate_sync ? params_.sync_tolerance : 0.0; }
  const Entry* nearest(const Slot& slot, ros::Time stamp) const {
    const auto best = std::min_element(
        slot.waiting.begin(), slot.waiting.end(), [&](const Entry& a, const Entry& b) {
          return difference_s(a.stamp, stamp) < difference_s(b.stamp, stamp);
        });
    return best == slot.waiting.end() ? nullptr : &*best;
  }

  std::optional<Set> setAt(ros::Time stamp) const {
    Set set;
    for (size_t i = 0; i < used_; ++i) {
      const Slot& slot = slots_[i];
      const Entry* entry = nearest(slot, stamp);
      if (entry && difference_s(entry->stamp, stamp) <= tolerance())
        set.push_back(entry->message);
      else if (slot.constant)
        set.push_back(slot.constant);
      else
        return std::nullopt;
    }
    return set;
  }

  // Drops what arrived before the set of this stamp: in a loop of a bag, later stamps, too, while
  // earlier ones may wait behind it. Drops partners that are slightly later than `stamp` as well.
  // Returns the number of messages of slot 0.
  size_t forgetUpTo(ros::Time stamp) {
    const size_t references = slots_[0].waiting.size();
    for (Slot& slot : slots_) {
      const double slack_s = &slot == &slots_[0] ? 0.0 : tolerance();
      const auto is_near = [&](const Entry& entry) {
        return difference_s(entry.stamp, stamp) <= slack_s;
      };
      const auto end = slot.waiting.end(), first = std::find_if(slot.waiting.begin(), end, is_near);
      if (first != end)
        slot.waiting.erase(slot.waiting.begin(), std::find_if_not(first, end, is_near));
    }
    return references - slots_[0].waiting.size();
  }

  SyncParams params_;
  std::vector<Slot> slots_;
  size_t used_;  // the first ones
  size_t unmatched_ = 0;
};

}  // namespace predictive_stereo
