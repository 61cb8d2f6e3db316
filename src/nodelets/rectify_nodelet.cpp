#include <image_transport/camera_common.h>
#include <image_transport/image_transport.h>
#include <nodelet/nodelet.h>

#include <array>
#include <boost/pointer_cast.hpp>
#include <chrono>
#include <memory>
#include <mutex>
#include <pluginlib/class_list_macros.hpp>
#include <string>
#include <vector>

#include "nodelets/callbacks.h"
#include "nodelets/health.h"
#include "nodelets/image_subscriber.h"
#include "nodelets/rectifier.h"
#include "nodelets/stamp_matcher.h"
#include "nodelets/topic_state.h"

namespace predictive_stereo {

/// Rectifies the images of one camera, for drivers that do not.
///
/// Subscribes, while image_rect has subscribers: image_raw, camera_info (with equal stamps).
/// Publishes: image_rect (mono8); /diagnostics.
/// Parameters: ~image_transport of image_raw: raw, compressed, or one that a plugin provides.
class RectifyNodelet : public nodelet::Nodelet {
 public:
  ~RectifyNodelet() override {
    if (health_) health_->stop();
    rectified_.shutdown();
    unsubscribe();
  }

 private:
  enum Slot { kImage, kInfo };
  static constexpr int kQueue = 5;

  void onInit() override {
    ros::NodeHandle& node = getNodeHandle();
    health_ = std::make_unique<Health>(node, getPrivateNodeHandle(), getName(), "Rectify",
                                       [this] { return describeMissingInput(); });
    health_->setAsleep(true);
    const auto connect = [this](const image_transport::SingleSubscriberPublisher&) {
      followSubscribers();
    };
    const std::lock_guard<std::mutex> lock(mutex_);  // a callback may run before this has returned
    getPrivateNodeHandle().param<std::string>("image_transport", transport_, "raw");
    image_topic_ = node.resolveName("image_raw");
    info_topic_ = image_transport::getCameraInfoTopic(image_topic_);
    SyncParams exact;
    exact.approximate_sync = false;
    exact.queue_size = kQueue;
    matcher_ = std::make_unique<StampMatcher>(std::vector{image_topic_, info_topic_}, exact);
    rectified_ =
        image_transport::ImageTransport(node).advertise("image_rect", kQueue, connect, connect);
    health_->start();
  }

  void followSubscribers() {
    const std::lock_guard<std::mutex> lock(mutex_);
    const bool wanted = rectified_.getNumSubscribers() > 0;
    health_->setAsleep(!wanted);
    const auto follow = [&] {
      if (!wanted)
        unsubscribe();
      else if (!raw_)
        subscribeBoth();
    };
    health_->guard("subscriptions", follow, Health::Severity::kBroken);
  }

  void subscribeBoth() {
    info_ = subscribe<sensor_msgs::CameraInfo>(
        getNodeHandle(), *health_, info_topic_, kQueue,
        [this](const sensor_msgs::CameraInfoConstPtr& info) {
          add(kInfo, info->header.stamp, info, info->header.stamp.isZero());
        },
        ZeroStamp::kLegal);
    raw_ = ImageSubscriber(getNodeHandle(), *health_, image_topic_, kQueue, transport_,
                           [this](const sensor_msgs::ImageConstPtr& image) {
                             add(kImage, image->header.stamp, image, false);
                           });
  }

  void unsubscribe() {
    raw_.shutdown();
    raw_ = ImageSubscriber();
    info_.shutdown();
    if (matcher_) matcher_->clear();
  }

  std::string describeMissingInput() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!raw_) return "";
    if (const std::string error = raw_.error(); !error.empty())
      return raw_.getTopic() + ": " + error;
    const std::vector<TopicState> topics = {
        {raw_.getTopic(), raw_.getNumPublishers(), last_received_[kImage]},
        {info_.getTopic(), info_.getNumPublishers(), last_received_[kInfo]}};
    if (const std::string unpublished = unpublishedOf(topics); !unpublished.empty())
      return "nobody publishes " + unpublished +
             ": start the camera driver in this namespace (launch argument camera:=<namespace>)";
    if (const std::string silent = silentOf(topics); !silent.empty())
      return "no message on " + silent +
             ", although it is advertised: is the camera running, or is the bag paused?";
    if (matcher_->describeMismatch().empty()) return "";
    return "no image on " + raw_.getTopic() + " has the stamp of a message on " + info_topic_ +
           ": the camera driver must give both the same stamp";
  }

  // Needs no lock: the callbacks of a nodelet's node handle are serialised, timers among them.
  void add(Slot slot, ros::Time stamp, const StampMatcher::Message& message, bool constant) {
    using boost::static_pointer_cast;
    last_received_[slot] = std::chrono::steady_clock::now();
    for (const StampMatcher::Set& set : matcher_->add(slot, stamp, message, constant))
      rectify(static_pointer_cast<const sensor_msgs::Image>(set[kImage]),
              static_pointer_cast<const sensor_msgs::CameraInfo>(set[kInfo]));
  }

  void rectify(const sensor_msgs::ImageConstPtr& raw, const sensor_msgs::CameraInfoConstPtr& info) {
    const auto process = [&] {
      Stopwatch watch;
      StageTimes times;
      rectified_.publish(rectifier_.rectify(*raw, *info));
      watch.lap("rectification", times);
      health_->frame(raw->header.stamp, times.front().ms, times);
    };
    health_->guard("input", process, Health::Severity::kBroken);
  }

  std::unique_ptr<Health> health_;
  Rectifier rectifier_;
  std::mutex mutex_;
  std::string transport_, image_topic_, info_topic_;
  std::unique_ptr<StampMatcher> matcher_;
  std::array<std::chrono::steady_clock::time_point, 2> last_received_{};
  image_transport::Publisher rectified_;
  ImageSubscriber raw_;
  ros::Subscriber info_;
};

}  // namespace predictive_stereo

PLUGINLIB_EXPORT_CLASS(predictive_stereo::RectifyNodelet, nodelet::Nodelet)
