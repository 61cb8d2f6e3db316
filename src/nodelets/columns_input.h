#pragma once

#include <predictive_stereo/RowAlignment.h>
#include <ros/node_handle.h>

#include <cstdint>
#include <string>

#include "nodelets/callbacks.h"
#include "nodelets/message_checks.h"
#include "nodelets/message_history.h"

namespace predictive_stereo {

/// Receives the offset of the right image's columns: see RowAlignment.
class ColumnsInput {
 public:
  ColumnsInput(const ros::NodeHandle& node, Health& health, const std::string& topic)
      : node_(node), health_(health), topic_(topic) {}

  void start(uint32_t queue) {
    subscription_.replace(subscribe<RowAlignment>(node_, health_, topic_, queue,
                                                  [this](const RowAlignmentConstPtr& columns) {
                                                    requireRowAlignment(*columns);
                                                    history_.add(columns);
                                                  }));
  }
  /// After this has returned, nothing is received.
  void stop() {
    subscription_.shutdown();
    history_.clear();
  }
  void goBackTo(ros::Time stamp) { history_.goBackTo(stamp); }
  const MessageHistory<RowAlignment>& history() const { return history_; }

 private:
  ros::NodeHandle node_;
  Health& health_;
  const std::string topic_;
  MessageHistory<RowAlignment> history_;
  Subscription subscription_;
};

}  // namespace predictive_stereo
