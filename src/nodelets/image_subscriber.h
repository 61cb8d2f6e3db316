#pragma once

#include <image_transport/subscriber.h>
#include <ros/node_handle.h>
#include <sensor_msgs/Image.h>

#include <functional>
#include <memory>
#include <mutex>
#include <string>

namespace predictive_stereo {

/// Images of a topic by one of the transports that image_transport knows.
///
/// "compressed" (JPEG, PNG) needs no plugin, which Debian 12 does not have: it is unpacked here.
class ImageSubscriber {
 public:
  using Callback = std::function<void(const sensor_msgs::ImageConstPtr&)>;

  /// Subscribes to nothing.
  ImageSubscriber() = default;

  /// @param transport  "raw", "compressed", or what a plugin of image_transport gives.
  /// @throws std::runtime_error where there is no such plugin.
  ImageSubscriber(ros::NodeHandle node, const std::string& topic, uint32_t queue,
                  const std::string& transport, const Callback& callback);

  /// No more calls once this has returned.
  void shutdown();

  uint32_t getNumPublishers() const;
  /// Name of the subscribed topic, with the suffix of the transport.
  std::string getTopic() const;
  /// Why the last image could not be unpacked; empty where it could.
  std::string error() const;
  explicit operator bool() const { return compressed_ || image_; }

 private:
  struct Error {
    std::mutex mutex;
    std::string text;
  };

  std::shared_ptr<Error> error_;
  ros::Subscriber compressed_;
  image_transport::Subscriber image_;
};

}  // namespace predictive_stereo
