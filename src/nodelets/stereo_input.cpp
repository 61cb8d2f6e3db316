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

StereoInput::StereoInput(const ros::NodeHandle& node, const ros::NodeHandle& private_node,
                         const SyncParams& params, std::function<void(const StereoPair&)> on_pair,
                         std::function<void(ros::Time)> on_backward)
    : node_(node),
      private_node_(private_node),
      queue_(std::max(kRoscppQueue, static_cast<uint32_t>(params.queue_size))),
      on_pair_(std::move(on_pair)),
      on_backward_(std::move(on_backward)),
      matcher_({node.resolveName("left/image_rect"), node.resolveName("left/camera_info"),
                node.resolveName("right/image_rect"), node.resolveName("right/camera_info")},
               params),
      transport_(node) {}

void StereoInput::start() {
  const image_transport::TransportHints hints("raw", ros::TransportHints().tcpNoDelay(),
                                              private_node_);
  using InfoPtr = sensor_msgs::CameraInfoConstPtr;
  using ImagePtr = sensor_msgs::ImageConstPtr;
  left_info_ = node_.subscribe<sensor_msgs::CameraInfo>(
      "left/camera_info", queue_, [this](const InfoPtr& info) { add(kLeftInfo, info, true); });
  right_info_ = node_.subscribe<sensor_msgs::CameraInfo>(
      "right/camera_info", queue_, [this](const InfoPtr& info) { add(kRightInfo, info, true); });
  left_ = transport_.subscribe(
      "left/image_rect", queue_, [this](const ImagePtr& image) { add(kLeft, image, false); },
      ros::VoidPtr(), hints);
  right_ = transport_.subscribe(
      "right/image_rect", queue_, [this](const ImagePtr& image) { add(kRight, image, false); },
      ros::VoidPtr(), hints);
}

void StereoInput::stop() {
  left_.shutdown();
  right_.shutdown();
  left_info_.shutdown();
  right_info_.shutdown();
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

std::string StereoInput::silence() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const std::vector<TopicState> topics = {
      {left_.getTopic(), left_.getNumPublishers(), last_received_[kLeft]},
      {left_info_.getTopic(), left_info_.getNumPublishers(), last_received_[kLeftInfo]},
      {right_.getTopic(), right_.getNumPublishers(), last_received_[kRight]},
      {right_info_.getTopic(), right_info_.getNumPublishers(), last_received_[kRightInfo]},
  };
  const std::string unpublished = unpublishedOf(topics), silent = silentOf(topics);
  if (!unpublished.empty())
    return "nobody publishes " + unpublished +
           ": run in the camera's namespace (launch argument camera:=<namespace>), or remap";
  if (!silent.empty())
    return "nothing comes on " + silent +
           " although it is advertised: is the camera running, or is the bag paused?";
  return matcher_.describeMismatch();
}

}  // namespace predictive_stereo
