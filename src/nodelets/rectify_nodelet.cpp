#include <image_transport/camera_common.h>
#include <image_transport/image_transport.h>
#include <nodelet/nodelet.h>

#include <boost/pointer_cast.hpp>
#include <memory>
#include <mutex>
#include <pluginlib/class_list_macros.hpp>
#include <string>
#include <vector>

#include "nodelets/health.h"
#include "nodelets/live_params.h"
#include "nodelets/rectifier.h"
#include "nodelets/synced_topics.h"

namespace predictive_stereo {
namespace {

/// Rectifies the images of one camera, for drivers that do not, while image_rect has subscribers.
/// Topics and parameters: docs/nodes.md.
class RectifyNodelet : public nodelet::Nodelet {
 public:
  ~RectifyNodelet() override {
    if (health_) health_->stop();
    rectified_.shutdown();
    if (input_) input_->stop();
  }

 private:
  static constexpr int kQueue = 5;
  static constexpr size_t kTopics = 2;

  void onInit() override {
    ros::NodeHandle& node = getNodeHandle();
    health_ = std::make_unique<Health>(node, getPrivateNodeHandle(), getName(), "Rectify", [this] {
      return input_ ? input_->describeMissingInput() : "";
    });
    health_->setAsleep(true);
    const std::lock_guard<std::mutex> lock(mutex_);  // a callback may run before this has returned
    makeInput(node);
    const auto connect = [this](const image_transport::SingleSubscriberPublisher&) {
      followSubscribers();
    };
    rectified_ =
        image_transport::ImageTransport(node).advertise("image_rect", kQueue, connect, connect);
    health_->start();
  }

  void makeInput(const ros::NodeHandle& node) {
    RectifyNodeletParams params;
    ParamTable table(params, getPrivateNodeHandle().getNamespace() + "/");
    for (const std::string& warning : setFromRosParams(getPrivateNodeHandle(), table))
      health_->warning(warning);
    const std::string images = node.resolveName("image_raw");
    const std::string infos = image_transport::getCameraInfoTopic(images);
    using Type = SyncedTopics::Type;
    input_ = std::make_unique<SyncedTopics>(
        node, *health_, SyncParams::exact(kQueue, params.image_transport),
        std::vector<SyncedTopics::Topic>{{images, Type::kCameraImage}, {infos, Type::kInfo}},
        SyncedTopics::Cures{
            "start the camera driver in this namespace (launch argument camera:=<namespace>)", "",
            "no image on " + images + " has the stamp of a message on " + infos +
                ": the camera driver must give both the same stamp"},
        [this](const SyncedTopics::Set& set) {
          rectify(boost::static_pointer_cast<const sensor_msgs::Image>(set[0]),
                  boost::static_pointer_cast<const sensor_msgs::CameraInfo>(set[1]));
        });
  }

  void followSubscribers() {
    const std::lock_guard<std::mutex> lock(mutex_);
    const bool wanted = rectified_.getNumSubscribers() > 0;
    health_->setAsleep(!wanted);
    health_->guard(
        "subscriptions", [&] { input_->start(wanted ? kTopics : 0); }, Health::Severity::kBroken);
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
  std::unique_ptr<SyncedTopics> input_;
  image_transport::Publisher rectified_;
};

}  // namespace
}  // namespace predictive_stereo

PLUGINLIB_EXPORT_CLASS(predictive_stereo::RectifyNodelet, nodelet::Nodelet)
