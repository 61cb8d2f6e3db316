#include "nodelets/image_subscriber.h"

#include <image_transport/image_transport.h>

#include <stdexcept>

#include "nodelets/compressed_image.h"

namespace predictive_stereo {

ImageSubscriber::ImageSubscriber(ros::NodeHandle node, Health& health, const std::string& topic,
                                 uint32_t queue, const std::string& transport,
                                 const Callback& callback)
    : error_(std::make_shared<Error>()) {
  const ros::TransportHints hints = ros::TransportHints().tcpNoDelay();
  if (transport == "compressed") {
    const auto unpack = [callback,
                         error = error_](const sensor_msgs::CompressedImageConstPtr& message) {
      sensor_msgs::ImageConstPtr image;
      std::string text;
      try {
        image = decodedImage(*message);
      } catch (const std::exception& e) {
        text = e.what();
      }
      {
        const std::lock_guard<std::mutex> lock(error->mutex);
        error->text = text;
      }
      if (image) callback(image);
    };
    compressed_ = subscribe<sensor_msgs::CompressedImage>(
        node, health, node.resolveName(topic) + kCompressedTopic, queue, unpack,
        ZeroStamp::kRefused, hints);
    return;
  }
  try {
    image_ = image_transport::ImageTransport(node).subscribe(
        topic, queue, guarded<sensor_msgs::Image>(health, node.resolveName(topic), callback),
        ros::VoidPtr(), image_transport::TransportHints(transport, hints));
  } catch (const image_transport::TransportLoadException& e) {
    throw std::runtime_error("image_transport = " + transport + ": cannot be used (" + e.what() +
                             "); set it to raw or compressed, or install its plugin package");
  }
}

void ImageSubscriber::shutdown() {
  compressed_.shutdown();
  image_.shutdown();
}

uint32_t ImageSubscriber::getNumPublishers() const {
  return compressed_ ? compressed_.getNumPublishers() : image_.getNumPublishers();
}

std::string ImageSubscriber::getTopic() const {
  return compressed_ ? compressed_.getTopic() : image_.getTopic();
}

std::string ImageSubscriber::error() const {
  if (!error_) return "";
  const std::lock_guard<std::mutex> lock(error_->mutex);
  return error_->text;
}

}  // namespace predictive_stereo
