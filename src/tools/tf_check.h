/// Checks whether the nodelets can use the tf of a bag.
#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <std_msgs/Header.h>
#include <tf2/buffer_core.h>

#include <limits>
#include <map>
#include <string>

#include "nodelets/transforms.h"
#include "tools/bag_check.h"

namespace predictive_stereo {

constexpr double kNoDelay_s = std::numeric_limits<double>::infinity();

/// ros::Duration throws for stamps that are 68 years apart or more.
inline double secondsBetween(ros::Time from, ros::Time to) { return to.toSec() - from.toSec(); }

/// The part of checkBag for the camera's mount and motion in tf: adds the launch arguments that
/// they need.
class TfCheck {
 public:
  void add(const geometry_msgs::TransformStamped& transform, bool is_static, ros::Time recorded);

  /// @param left  header of the first left image.
  /// @param image_delay_s  least time from a left image's stamp until it was recorded.
  /// @param odometries  topics of the bag, separated by ", ".
  void check(const std_msgs::Header& left, double image_delay_s, const std::string& odometries,
             BagCheck& result) const;

 private:
  // A frame that tf moves.
  struct MovingFrame {
    std::string parent;
    ros::Time first;                    // stamp
    double least_delay_s = kNoDelay_s;  // from a stamp until it was recorded
  };

  tf2::BufferCore tf_{ros::Duration(2 * kLookedAt_s)};
  FixedFrames fixed_;
  std::map<std::string, MovingFrame> moving_;  // by child
};

}  // namespace predictive_stereo
