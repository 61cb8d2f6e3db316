#pragma once

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "tools/bag_check.h"

namespace predictive_stereo {

/// As printf.
template <class... Values>
std::string format(const char* text, Values... values) {
  char buffer[1024];
  std::snprintf(buffer, sizeof(buffer), text, values...);
  return buffer;
}

/// The stamps of one topic.
struct StampStream {
  std::string topic;
  std::vector<ros::Time> stamps;

  bool unstamped() const {
    return std::any_of(stamps.begin(), stamps.end(), [](ros::Time t) { return t.isZero(); });
  }
};

/// Checks rate, gaps and synchronisation of a camera, and adds a launch argument if stamps differ.
/// @param streams  left, right, left_info, right_info; each has stamps.
void checkStamps(const std::vector<StampStream>& streams, BagCheck& result);

}  // namespace predictive_stereo
