#include "nodelets/topic_state.h"

namespace predictive_stereo {
namespace {

template <class Which>
std::string namesOf(const std::vector<TopicState>& topics, Which&& which) {
  std::string names;
  for (const TopicState& topic : topics)
    if (which(topic)) names += (names.empty() ? "" : ", ") + topic.name;
  return names;
}

}  // namespace

std::string unpublishedOf(const std::vector<TopicState>& topics) {
  return namesOf(topics, [](const TopicState& topic) { return topic.publishers == 0; });
}

std::string silentOf(const std::vector<TopicState>& topics) {
  return namesOf(topics, [](const TopicState& topic) { return topic.isSilent(); });
}

}  // namespace predictive_stereo
