#pragma once

#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <map>
#include <string>
#include <vector>

namespace predictive_stereo {

/// All messages of one type in a bag, by topic, in order.
template <class Message>
std::map<std::string, std::vector<typename Message::ConstPtr>> messagesIn(const std::string& path) {
  std::map<std::string, std::vector<typename Message::ConstPtr>> result;
  rosbag::Bag bag(path);
  for (const rosbag::MessageInstance& instance : rosbag::View(bag))
    if (const auto message = instance.instantiate<Message>())
      result[instance.getTopic()].push_back(message);
  return result;
}

}  // namespace predictive_stereo
