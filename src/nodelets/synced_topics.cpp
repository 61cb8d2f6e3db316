#include "nodelets/synced_topics.h"

#include <image_transport/image_transport.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace predictive_stereo {
namespace {

constexpr auto kSilence = std::chrono::seconds(2);

std::vector<std::string> namesOf(const ros::NodeHandle& node,
                                 const std::vector<SyncedTopics::Topic>& topics) {
  std::vector<std::string> names;
  for (const auto& topic : topics) names.push_back(node.resolveName(topic.name));
  return names;
}

bool isOfCamera(SyncedTopics::Type type) {
  using Type = SyncedTopics::Type;
  return type == Type::kCameraImage || type == Type::kInfo || type == Type::kFixedInfo;
}

void append(const std::string& name, std::string& names) {
  names += (names.empty() ? "" : ", ") + name;
}

}  // namespace

SyncedTopics::SyncedTopics(const ros::NodeHandle& node, Health& health, const SyncParams& params,
                           const std::vector<Topic>& topics, Cures cures,
                           std::function<void(const Set&)> on_set)
    : node_(node),
      health_(health),
      params_(params),
      queue_(std::max(kRoscppQueue, static_cast<uint32_t>(params.queue_size))),
      cures_(std::move(cures)),
      on_set_(std::move(on_set)),
      matcher_(namesOf(node, topics), params) {
  for (const Topic& topic : topics) slots_.push_back({topic, {}});
}

void SyncedTopics::start(size_t count) {
  std::vector<Subscriber> before, now;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (subscribers_.size() == count) return;
    std::swap(before, subscribers_);
  }
  // Without the lock: shutdown() waits for callbacks, and these take the lock.
  for (Subscriber& subscriber : before)
    std::visit([](auto& topic) { topic.shutdown(); }, subscriber);
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    matcher_.use(count);
  }
  for (size_t slot = 0; slot < count; ++slot) now.push_back(subscriberOf(slot));
  const std::lock_guard<std::mutex> lock(mutex_);
  subscribers_ = std::move(now);
}

SyncedTopics::Subscriber SyncedTopics::subscriberOf(size_t slot) {
  const auto& [topic, type] = slots_[slot].topic;
  switch (type) {
    case Type::kCameraImage:
      return cameraImages(slot, topic);
    case Type::kImage:
      return messages<sensor_msgs::Image>(slot, topic);
    case Type::kDisparity:
      return messages<stereo_msgs::DisparityImage>(slot, topic);
    case Type::kInfo:
    case Type::kFixedInfo:
      break;
  }
  return messages<sensor_msgs::CameraInfo>(slot, topic, ZeroStamp::kLegal);
}

template <class Message>
SyncedTopics::Subscriber SyncedTopics::messages(size_t slot, const std::string& topic,
                                                ZeroStamp zero) {
  return subscribe<Message>(
      node_, health_, topic, queue_,
      [this, slot](const boost::shared_ptr<const Message>& message) { add(slot, message); }, zero);
}

SyncedTopics::Subscriber SyncedTopics::cameraImages(size_t slot, const std::string& topic) {
  const std::string& transport = params_.image_transport;
  if (transport == "compressed")
    return messages<sensor_msgs::CompressedImage>(slot,
                                                  node_.resolveName(topic) + kCompressedTopic);
  const Receiver<sensor_msgs::Image> use = [this, slot](const sensor_msgs::ImageConstPtr& image) {
    add(slot, image);
  };
  try {
    return image_transport::ImageTransport(node_).subscribe(
        topic, queue_, guarded<sensor_msgs::Image>(health_, node_.resolveName(topic), use),
        ros::VoidPtr(),
        image_transport::TransportHints(transport, ros::TransportHints().tcpNoDelay()));
  } catch (const image_transport::TransportLoadException& e) {
    throw std::runtime_error("image_transport = " + transport + ": cannot be used (" + e.what() +
                             "); set it to raw or compressed, or install its plugin package");
  }
}

void SyncedTopics::markReceived(size_t slot) {
  const std::lock_guard<std::mutex> lock(mutex_);
  slots_[slot].last_received = Clock::now();
}

void SyncedTopics::add(size_t slot, const sensor_msgs::CompressedImageConstPtr& image) {
  markReceived(slot);  // also if it cannot be decoded
  add(slot, sensor_msgs::ImageConstPtr(decodedImage(*image)));
}

template <class Message>
void SyncedTopics::add(size_t slot, const boost::shared_ptr<const Message>& message) {
  const ros::Time stamp = message->header.stamp;
  const Type type = slots_[slot].topic.type;
  const bool constant = type == Type::kFixedInfo || (type == Type::kInfo && stamp.isZero());
  markReceived(slot);
  std::vector<Set> sets;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    sets = matcher_.add(slot, stamp, message, constant);
  }
  for (const Set& set : sets) on_set_(set);
}

size_t SyncedTopics::unmatched() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return matcher_.unmatched();
}

// A calibration that belongs to every frame need not arrive again.
bool SyncedTopics::isSilent(const Slot& slot) {
  if (slot.topic.type == Type::kFixedInfo && slot.last_received != Clock::time_point())
    return false;
  return Clock::now() - slot.last_received > kSilence;
}

std::string SyncedTopics::describeMissingInput() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::string unpublished, silent_camera, silent_others;
  for (size_t slot = 0; slot < subscribers_.size(); ++slot)
    std::visit(
        [&](const auto& subscriber) {
          if (subscriber.getNumPublishers() == 0)
            append(subscriber.getTopic(), unpublished);
          else if (isSilent(slots_[slot]))
            append(subscriber.getTopic(),
                   isOfCamera(slots_[slot].topic.type) ? silent_camera : silent_others);
        },
        subscribers_[slot]);
  if (!unpublished.empty()) return "nobody publishes " + unpublished + ": " + cures_.unpublished;
  // Without images there is nothing else either, so this is the cause.
  if (!silent_camera.empty())
    return "no messages arrive on " + silent_camera +
           " although it is advertised: is the camera running, or is the bag paused?";
  if (!silent_others.empty())
    return "no messages arrive on " + silent_others +
           " although it is advertised: " + cures_.silent;
  const std::string mismatch = subscribers_.empty() ? "" : matcher_.describeMismatch();
  return mismatch.empty() || cures_.mismatch.empty() ? mismatch : cures_.mismatch;
}

}  // namespace predictive_stereo
