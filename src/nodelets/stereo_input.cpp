#include "nodelets/stereo_input.h"

#include <algorithm>
#include <boost/pointer_cast.hpp>
#include <utility>
#include <vector>

#include "nodelets/topic_state.h"

namespace predictive_stereo {
namespace {

enum Slot { kLeft, kLeftInfo, kRight, kRightInfo };

}  // namespace

StereoInput::StereoInput(const ros::NodeHandle& node, Health& health, const SyncParams& params,
                         std::function<void(const StereoPair&)> on_pair,
                         std::function<void(ros::Time)> on_backward)
    : node_(node),
      health_(health),
      transport_(params.image_transport),
      queue_(std::max(kRoscppQueue, static_cast<uint32_t>(params.queue_size))),
      on_pair_(std::move(on_pair)),
      on_backward_(std::move(on_backward)),
      matcher_({node.resolveName("left/image_rect"), node.resolveName("left/camera_info"),
                node.resolveName("right/image_rect"), node.resolveName("right/camera_info")},
               params) {}

void StereoInput::start() {
  const auto infos = [&](const char* topic, Slot slot) {
    return subscribe<sensor_msgs::CameraInfo>(
        node_, health_, topic, queue_,
        [this, slot](const sensor_msgs::CameraInfoConstPtr& info) { add(slot, info, true); },
        ZeroStamp::kLegal);
  };
  const auto images = [&](const char* topic, Slot slot) {
    return ImageSubscriber(
        node_, health_, topic, queue_, transport_,
        [this, slot](const sensor_msgs::ImageConstPtr& image) { add(slot, image, false); });
  };
  Subscribers subscribers;
  subscribers.left_info = infos("left/camera_info", kLeftInfo);
  subscribers.right_info = infos("right/camera_info", kRightInfo);
  subscribers.left = images("left/image_rect", kLeft);
  subscribers.right = images("right/image_rect", kRight);
  const std::lock_guard<std::mutex> lock(mutex_);
  subscribers_ = subscribers;
}

void StereoInput::stop() {
  Subscribers subscribers;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::swap(subscribers, subscribers_);
  }
  // Without the lock: shutdown() waits for callbacks, and these take the lock.
  subscribers.left.shutdown();
  subscribers.right.shutdown();
  subscribers.left_info.shutdown();
  subscribers.right_info.shutdown();
  const std::lock_guard<std::mutex> lock(mutex_);
  matcher_.clear();
}

template <class Message>
void StereoInput::add(size_t slot, const boost::shared_ptr<const Message>& message,
                      bool may_be_constant) {
  const ros::Time stamp = message->header.stamp;
  std::vector<StereoPair> pairs;
  bool backward = false;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    last_received_[slot] = std::chrono::steady_clock::now();
    for (const StampMatcher::Set& set :
         matcher_.add(slot, stamp, message, may_be_constant && stamp.isZero())) {
      StereoPair pair;
      pair.left = boost::static_pointer_cast<const sensor_msgs::Image>(set[kLeft]);
      pair.right = boost::static_pointer_cast<const sensor_msgs::Image>(set[kRight]);
      pair.left_info = boost::static_pointer_cast<const sensor_msgs::CameraInfo>(set[kLeftInfo]);
      pair.right_info = boost::static_pointer_cast<const sensor_msgs::CameraInfo>(set[kRightInfo]);
      backward |= pair.left->header.stamp < last_stamp_;
      last_stamp_ = pair.left->header.stamp;
      pairs.push_back(std::move(pair));
    }
  }
  if (backward) on_backward_(pairs.front().left->header.stamp);
  for (const StereoPair& pair : pairs) on_pair_(pair);
}

size_t StereoInput::unmatched() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return matcher_.unmatched();
}

std::string StereoInput::describeMissingInput() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!subscribers_.left) return "";
  for (const ImageSubscriber* images : {&subscribers_.left, &subscribers_.right})
    if (const std::string error = images->error(); !error.empty())
      return images->getTopic() + ": " + error;
  const auto state = [&](Slot slot, const auto& subscriber) {
    return TopicState{subscriber.getTopic(), subscriber.getNumPublishers(), last_received_[slot]};
  };
  const std::vector<TopicState> topics = {
      state(kLeft, subscribers_.left), state(kLeftInfo, subscribers_.left_info),
      state(kRight, subscribers_.right), state(kRightInfo, subscribers_.right_info)};
  const std::string unpublished = unpublishedOf(topics), silent = silentOf(topics);
  if (!unpublished.empty())
    return "nobody publishes " + unpublished +
           ": run in the camera's namespace (launch argument camera:=<namespace>), or remap";
  if (!silent.empty())
    return "no messages arrive on " + silent +
           " although it is advertised: is the camera running, or is the bag paused?";
  return matcher_.describeMismatch();
}

}  // namespace predictive_stereo
