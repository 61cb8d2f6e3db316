#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace predictive_stereo {

/// What a subscriber knows of a topic.
struct TopicState {
  std::string name;
  uint32_t publishers = 0;
  std::chrono::steady_clock::time_point last_received;

  bool isSilent() const {
    return publishers > 0 &&
           std::chrono::steady_clock::now() - last_received > std::chrono::seconds(2);
  }
};

/// Names of the topics that nobody publishes, separated by commas.
std::string unpublishedOf(const std::vector<TopicState>& topics);

/// Names of the topics that are published, but on which nothing has come for two seconds.
std::string silentOf(const std::vector<TopicState>& topics);

}  // namespace predictive_stereo
