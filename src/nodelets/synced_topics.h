#pragma once

#include <image_transport/subscriber.h>
#include <ros/node_handle.h>

#include <boost/pointer_cast.hpp>
#include <chrono>
#include <functional>
#include <mutex>
#include <string>
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
               std::function<void(const Set&)> on_set);

  /// Does nothing if it is started with this count. With another one it starts anew.
  /// @param count  so many topics make a frame, from the first one on.
  /// @throws std::runtime_error if the plugin of the image transport is missing.
  void start(size_t count);
  /// After this has returned, `on_set` is not called.
  void stop() { start(0); }

  /// Why there are no frames, and the cure; empty: they arrive, or it is stopped.
  std::string describeMissingInput() const;
  /// Number of messages of the first topic without partners.
  size_t unmatched() const;

 private:
  using Clock = std::chrono::steady_clock;
  using Subscriber = std::variant<ros::Subscriber, image_transport::Subscriber>;
  struct Slot {
    Topic topic;
    Clock::time_point last_received;
  };

  Subscriber subscriberOf(size_t slot);
  Subscriber cameraImages(size_t slot, const std::string& topic);
  template <class Message>
  Subscriber messages(size_t slot, const std::string& topic, ZeroStamp zero = ZeroStamp::kRefused);
  void add(size_t slot, const sensor_msgs::CompressedImageConstPtr& image);
  template <class Message>
  void add(size_t slot, const boost::shared_ptr<const Message>& message);
  void markReceived(size_t slot);
  static bool isSilent(const Slot& slot);

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
    return {"run in the camera's namespace (launch argument camera:=<namespace>), or remap", "",
            ""};
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
