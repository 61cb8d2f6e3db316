#pragma once

#include <image_transport/subscriber.h>
#include <ros/node_handle.h>
#include <sensor_msgs/Image.h>

#include <memory>
#include <mutex>
#include <string>

#include "nodelets/callbacks.h"

namespace predictive_stereo {

/// Subscriber of an image topic, with any transport of image_transport.
///
/// "compressed" (JPEG, PNG) is decoded here and needs no plugin, because Debian 12 has none.
class ImageSubscriber {
 public:
  using Callback = Receiver<sensor_msgs::Image>;

  /// Makes an object without a subscription.
  ImageSubscriber() = default;

  /// @param transport  "raw", "compressed", or one that a plugin of image_transport provides.
  /// @throws std::runtime_error if there is no such plugin.
  ImageSubscriber(ros::NodeHandle node, Health& health, const std::string& topic, uint32_t queue,
                  const std::string& transport, const Callback& callback);

  /// After this has returned, the callback is not called.
  void shutdown();

  uint32_t getNumPublishers() const;
  /// Name of the subscribed topic, with the suffix of the transport.
  std::string getTopic() const;
  /// Why the last image could not be decoded; empty: it was decoded.
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
