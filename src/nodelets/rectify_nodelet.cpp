#include <image_transport/image_transport.h>
#include <nodelet/nodelet.h>

#include <chrono>
#include <memory>
#include <mutex>
#include <pluginlib/class_list_macros.hpp>
#include <string>

#include "nodelets/health.h"
#include "nodelets/rectifier.h"

namespace predictive_stereo {

/// Rectifies one camera, for drivers that do not.
///
/// Subscribes: image_raw, camera_info (of equal stamps), while image_rect has subscribers.
/// Publishes: image_rect (mono8); /diagnostics.
class RectifyNodelet : public nodelet::Nodelet {
 public:
  ~RectifyNodelet() override {
    if (health_) health_->stop();
  }

 private:
  static constexpr int kQueue = 5;

  void onInit() override {
    ros::NodeHandle& node = getNodeHandle();
    health_ = std::make_unique<Health>(node, getPrivateNodeHandle(), getName(), "Rectify",
                                       [this] { return silence(); });
    health_->asleep(true);
    const auto connect = [this](const image_transport::SingleSubscriberPublisher&) {
      followSubscribers();
    };
    const std::lock_guard<std::mutex> lock(mutex_);  // the first may come before this has returned
    transport_ = std::make_unique<image_transport::ImageTransport>(node);
    rectified_ = transport_->advertise("image_rect", kQueue, connect, connect);
    health_->start();
  }

  void followSubscribers() {
    const std::lock_guard<std::mutex> lock(mutex_);
    const bool wanted = rectified_.getNumSubscribers() > 0;
    health_->asleep(!wanted);
    if (!wanted) {
      raw_.shutdown();
    } else if (!raw_) {
      const image_transport::TransportHints hints("raw", ros::TransportHints().tcpNoDelay(),
                                                  getPrivateNodeHandle());
      raw_ =
          transport_->subscribeCamera("image_raw", kQueue, &RectifyNodelet::rectify, this, hints);
    }
  }

  std::string silence() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!raw_) return "";
    const std::string image = raw_.getTopic(), info = raw_.getInfoTopic();
    if (raw_.getNumPublishers() == 0)
      return "nobody publishes both " + image + " and " + info +
             ": start the camera driver in this namespace (launch argument camera:=<namespace>)";
    return "no " + image + " comes with a " + info + " of the same stamp";
  }

  void rectify(const sensor_msgs::ImageConstPtr& raw, const sensor_msgs::CameraInfoConstPtr& info) {
    try {
      Stopwatch watch;
      StageTimes times;
      rectified_.publish(rectifier_.rectify(*raw, *info));
      watch.lap("rectification", times);
      health_->solved("input");
      health_->frame(raw->header.stamp, times.front().ms, times);
    } catch (const std::exception& error) {
      health_->problem("input", Health::Severity::kBroken, error.what());
    }
  }

  std::unique_ptr<Health> health_;
  Rectifier rectifier_;
  std::mutex mutex_;
  std::unique_ptr<image_transport::ImageTransport> transport_;
  image_transport::Publisher rectified_;
  image_transport::CameraSubscriber raw_;
};

}  // namespace predictive_stereo

PLUGINLIB_EXPORT_CLASS(predictive_stereo::RectifyNodelet, nodelet::Nodelet)
