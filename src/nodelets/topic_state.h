#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace predictive_stereo {

/// State of a subscribed topic.
struct TopicState {
  std::string name;
  uint32_t publishers = 0;
  std::chrono::steady_clock::time_point last_received;

  bool isSilent() const {
    return publishers > 0 &&
           std::chrono::steady_clock::now() - last_received > std::chrono::seconds(2);
  }
};

/// Names of the topics without a publisher, separated by commas.
std::string unpublishedOf(const std::vector<TopicState>& topics);

/// Names of the topics that have a publisher, but no message for two seconds.
std::string silentOf(const std::vector<TopicState>& topics);

}  // namespace predictive_stereo
