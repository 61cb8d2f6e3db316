#pragma once

#include <image_transport/image_transport.h>
#include <image_transport/subscriber.h>
#include <ros/node_handle.h>

#include <algorithm>
#include <boost/algorithm/string/predicate.hpp>
#include <boost/pointer_cast.hpp>
#include <chrono>
#include <functional>
#include <mutex>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "nodelets/callbacks.h"
#include "nodelets/stamp_matcher.h"
#include "nodelets/stereo_messages.h"

namespace predictive_stereo {

/// The topics that make the frames of a nodelet. Between start() and stop() it subscribes to them
/// and joins their messages of one stamp. It can be started and stopped repeatedly.
///
/// "compressed" images (JPEG, PNG) are decoded here and need no plugin, because Debian 12 has none.
class SyncedTopics {
 public:
  using Set = StampMatcher::Set;

  enum class Type {
    kCameraImage,  ///< by SyncParams::image_transport
    kImage,
    kDisparity,
    kInfo,       ///< a calibration with stamp 0 belongs to every frame
    kFixedInfo,  ///< the last calibration belongs to every frame, whatever its stamp
  };
  struct Topic {
    std::string name;
    Type type;
  };
  /// What a user can do about topics without messages.
  struct Cures {
    std::string unpublished;
    std::string silent;    ///< topics of other nodelets, although the camera's messages arrive
    std::string mismatch;  ///< of stamps; empty: that of StampMatcher
  };

  /// @param topics  the messages of the first one need partners, see StampMatcher.
  /// @param on_set  called with the messages of each frame, in the order of the topics, from the
  ///   node handle's callback queue; may throw.
  SyncedTopics(const ros::NodeHandle& node, Health& health, const SyncParams& params,
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

  /// Does nothing if it is started with this count. With another one it starts anew.
  /// @param count  so many topics make a frame, from the first one on.
  /// @throws std::runtime_error if the plugin of the image transport is missing, or if the name of
  ///   an image topic is that of its compressed images.
  void start(size_t count) {
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
  /// After this has returned, `on_set` is not called.
  void stop() { start(0); }

  /// Why there are no frames, and the cure; empty: they arrive, or it is stopped.
  std::string describeMissingInput() const {
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

  /// Number of messages of the first topic without partners.
  size_t unmatched() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return matcher_.unmatched();
  }

 private:
  static constexpr auto kSilence = std::chrono::seconds(2);

  static std::vector<std::string> namesOf(const ros::NodeHandle& node,
                                          const std::vector<Topic>& topics) {
    std::vector<std::string> names;
    for (const auto& topic : topics) names.push_back(node.resolveName(topic.name));
    return names;
  }

  static bool isOfCamera(Type type) {
    return type == Type::kCameraImage || type == Type::kInfo || type == Type::kFixedInfo;
  }

  static void append(const std::string& name, std::string& names) {
    names += (names.empty() ? "" : ", ") + name;
  }

  using Clock = std::chrono::steady_clock;
  using Subscriber = std::variant<ros::Subscriber, image_transport::Subscriber>;
  struct Slot {
    Topic topic;
    Clock::time_point last_received;
  };

  Subscriber subscriberOf(size_t slot) {
    const auto& [topic, type] = slots_[slot].topic;
    if (type == Type::kCameraImage) return cameraImages(slot, topic);
    if (type == Type::kImage) return messages<sensor_msgs::Image>(slot, topic);
    if (type == Type::kDisparity) return messages<stereo_msgs::DisparityImage>(slot, topic);
    return messages<sensor_msgs::CameraInfo>(slot, topic, ZeroStamp::kLegal);
  }

  Subscriber cameraImages(size_t slot, const std::string& topic) {
    const std::string &transport = params_.image_transport, images = node_.resolveName(topic);
    if (boost::ends_with(images, kCompressedTopic))
      throw std::runtime_error(images + " has no raw images: give its name without " +
                               kCompressedTopic + ", and set image_transport to compressed");
    if (transport == "compressed")
      return subscribe<sensor_msgs::CompressedImage>(
          node_, health_, images + kCompressedTopic, queue_,
          [this, slot](const sensor_msgs::CompressedImageConstPtr& image) {
            markReceived(slot);  // also if it cannot be decoded
            add(slot, sensor_msgs::ImageConstPtr(decodedImage(*image)));
          });
    const Receiver<sensor_msgs::Image> use = [this, slot](const sensor_msgs::ImageConstPtr& image) {
      add(slot, image);
    };
    try {
      return image_transport::ImageTransport(node_).subscribe(
          topic, queue_, guarded<sensor_msgs::Image>(health_, images, use), ros::VoidPtr(),
          image_transport::TransportHints(transport, ros::TransportHints().tcpNoDelay()));
    } catch (const image_transport::TransportLoadException& e) {
      throw std::runtime_error("image_transport = " + transport + ": cannot be used (" + e.what() +
                               "); set it to raw or compressed, or install its plugin package");
    }
  }

  template <class Message>
  Subscriber messages(size_t slot, const std::string& topic, ZeroStamp zero = ZeroStamp::kRefused) {
    return subscribe<Message>(
        node_, health_, topic, queue_,
        [this, slot](const boost::shared_ptr<const Message>& message) { add(slot, message); },
        zero);
  }

  template <class Message>
  void add(size_t slot, const boost::shared_ptr<const Message>& message) {
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

  void markReceived(size_t slot) {
    const std::lock_guard<std::mutex> lock(mutex_);
    slots_[slot].last_received = Clock::now();
  }

  // A calibration that belongs to every frame need not arrive again.
  static bool isSilent(const Slot& slot) {
    if (slot.topic.type == Type::kFixedInfo && slot.last_received != Clock::time_point())
      return false;
    return Clock::now() - slot.last_received > kSilence;
  }

  ros::NodeHandle node_;
  Health& health_;
  const SyncParams params_;
  const uint32_t queue_;
  const Cures cures_;
  const std::function<void(const Set&)> on_set_;

  mutable std::mutex mutex_;
  std::vector<Slot> slots_;
  StampMatcher matcher_;
  std::vector<Subscriber> subscribers_;  // of the first slots; empty: stopped
};

/// The four topics of a stereo camera.
struct StereoInput {
  using Frame = StereoPair;

  static std::vector<SyncedTopics::Topic> topics() {
    using Type = SyncedTopics::Type;
    return {{"left/image_rect", Type::kCameraImage},
            {"left/camera_info", Type::kInfo},
            {"right/image_rect", Type::kCameraImage},
            {"right/camera_info", Type::kInfo}};
  }

  static SyncedTopics::Cures cures() {
    return {
        "start the camera driver, run in its namespace (launch argument camera:=<namespace>), or "
        "remap",
        "", ""};
  }

  static StereoPair frame(const SyncedTopics::Set& set) {
    using boost::static_pointer_cast;
    return {static_pointer_cast<const sensor_msgs::Image>(set[0]),
            static_pointer_cast<const sensor_msgs::Image>(set[2]),
            static_pointer_cast<const sensor_msgs::CameraInfo>(set[1]),
            static_pointer_cast<const sensor_msgs::CameraInfo>(set[3])};
  }
};

}  // namespace predictive_stereo
