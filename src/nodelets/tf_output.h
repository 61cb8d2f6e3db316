#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <ros/node_handle.h>

#include <chrono>

#include "nodelets/arrivals.h"
#include "nodelets/health.h"
#include "nodelets/tf_rivals.h"

namespace predictive_stereo {

/// Publishes a frame in tf, unless another node does: two publishers of the same frame are worse
/// than none, so a node that finds a rival stops.
class TfOutput {
 public:
  void start(ros::NodeHandle& node);
  /// Gets every transform that is received.
  TfRivals& rivals() { return rivals_; }
  void publish(const geometry_msgs::TransformStamped& transform, Health& health,
               Arrivals& arrivals);

 private:
  bool mayPublish(const std::string& frame, Health& health, Arrivals& arrivals);

  ros::Publisher publisher_;
  TfRivals rivals_;
  std::chrono::steady_clock::time_point listening_since_;
  bool asked_ = false;    // it has waited for transforms of rivals
  bool yielded_ = false;  // it does not publish because of a rival
};

}  // namespace predictive_stereo
