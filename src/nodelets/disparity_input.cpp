#include "nodelets/disparity_input.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "nodelets/message_checks.h"
#include "nodelets/topic_state.h"

namespace predictive_stereo {
namespace {

// In the order of the slots.
constexpr const char* kNames[] = {"measured_disparity", "measured_variance", "predicted_disparity",
                                  "predicted_variance", "left/image_rect",   "left/camera_info"};

std::vector<std::string> resolved(const ros::NodeHandle& node) {
  std::vector<std::string> topics;
  for (const char* name : kNames) topics.push_back(node.resolveName(name));
  return topics;
}

// Every input has the left image's stamp, but for the calibration.
SyncParams exactSync(int queue_size) {
  SyncParams exact;
  exact.approximate_sync = false;
  exact.queue_size = queue_size;
  return exact;
}

}  // namespace

DisparityInput::DisparityInput(const ros::NodeHandle& node, Health& health,
                               const MovingObjectsNodeletParams& params,
                               std::function<void(const MovingObjectsInput&)> on_frame,
                               std::function<void(ros::Time)> on_backward)
    : node_(node),
      health_(health),
      params_(params),
      on_frame_(std::move(on_frame)),
      on_backward_(std::move(on_backward)),
      matcher_(resolved(node), exactSync(params.queue_size)),
      columns_(node, health, "row_alignment") {}

void DisparityInput::start() {
  Subscribers subscribers;
  const uint32_t queue = std::max(kRoscppQueue, static_cast<uint32_t>(params_.queue_size));
  const auto subscribeTo = [&](Slot slot, auto type) {
    using Message = typename decltype(type)::element_type;
    subscribers.others[slot] = subscribe<Message>(
        node_, health_, kNames[slot], queue,
        [this, slot](const boost::shared_ptr<const Message>& message) { add(slot, message); },
        slot == kLeftInfo ? ZeroStamp::kLegal : ZeroStamp::kRefused);
  };
  subscribeTo(kLeftInfo, boost::shared_ptr<sensor_msgs::CameraInfo>());
  subscribeTo(kMeasured, boost::shared_ptr<stereo_msgs::DisparityImage>());
  subscribeTo(kMeasuredVariance, boost::shared_ptr<sensor_msgs::Image>());
  subscribeTo(kPredicted, boost::shared_ptr<stereo_msgs::DisparityImage>());
  subscribeTo(kPredictedVariance, boost::shared_ptr<sensor_msgs::Image>());
  columns_.start(queue);
  subscribers.left =
      ImageSubscriber(node_, health_, kNames[kLeft], queue, params_.image_transport,
                      [this](const sensor_msgs::ImageConstPtr& image) { add(kLeft, image); });
  const std::lock_guard<std::mutex> lock(mutex_);
  subscribers_ = subscribers;
}

void DisparityInput::stop() {
  Subscribers subscribers;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::swap(subscribers, subscribers_);
  }
  // Without the lock: shutdown() waits for callbacks, and these take the lock.
  subscribers.left.shutdown();
  for (ros::Subscriber& subscriber : subscribers.others) subscriber.shutdown();
  columns_.stop();
  const std::lock_guard<std::mutex> lock(mutex_);
  matcher_.clear();
}

template <class Message>
void DisparityInput::add(Slot slot, const boost::shared_ptr<const Message>& message) {
  const ros::Time stamp = message->header.stamp;
  const std::lock_guard<std::mutex> lock(mutex_);
  last_received_[slot] = std::chrono::steady_clock::now();
  if (slot == kLeft) {
    if (stamp < last_left_) {
      on_backward_(stamp);
      columns_.goBackTo(stamp);
    }
    last_left_ = stamp;
  }
  // The last calibration belongs to all frames: its stamp may differ from the image's, as far as
  // the other nodelets allow (sync_tolerance).
  for (const StampMatcher::Set& set : matcher_.add(slot, stamp, message, slot == kLeftInfo))
    on_frame_(frameOf(set));
}

MovingObjectsInput DisparityInput::frameOf(const StampMatcher::Set& set) const {
  using boost::static_pointer_cast;
  MovingObjectsInput input;
  input.left = static_pointer_cast<const sensor_msgs::Image>(set[kLeft]);
  input.left_info = static_pointer_cast<const sensor_msgs::CameraInfo>(set[kLeftInfo]);
  input.measured_disparity = static_pointer_cast<const stereo_msgs::DisparityImage>(set[kMeasured]);
  input.predicted_disparity =
      static_pointer_cast<const stereo_msgs::DisparityImage>(set[kPredicted]);
  input.measured_variance = static_pointer_cast<const sensor_msgs::Image>(set[kMeasuredVariance]);
  input.predicted_variance = static_pointer_cast<const sensor_msgs::Image>(set[kPredictedVariance]);
  const ros::Time of_set = input.left->header.stamp;
  const RowAlignmentConstPtr columns = columns_.history().at(of_set);
  if (columns && columns->header.stamp == of_set) input.row_alignment = columns;
  return input;
}

std::string DisparityInput::describeMissingInput() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!subscribers_.left) return "";
  if (const std::string error = subscribers_.left.error(); !error.empty())
    return subscribers_.left.getTopic() + ": " + error;
  std::vector<TopicState> topics;
  for (size_t slot = 0; slot < kTopics; ++slot)
    topics.push_back(
        {slot == kLeft ? subscribers_.left.getTopic() : subscribers_.others[slot].getTopic(),
         slot == kLeft ? subscribers_.left.getNumPublishers()
                       : subscribers_.others[slot].getNumPublishers(),
         last_received_[slot]});
  const std::string unpublished = unpublishedOf(topics), silent = silentOf(topics);
  if (!unpublished.empty())
    return "nobody publishes " + unpublished +
           ": run the Disparity nodelet in the same namespace (launch argument "
           "camera:=<namespace>), or remap";
  // Without images there are no disparities either, so this is the cause.
  if (topics[kLeft].isSilent())
    return "no messages arrive on " + topics[kLeft].name +
           " although it is advertised: is the camera running, or is the bag paused?";
  if (!silent.empty())
    return "no messages arrive on " + silent +
           " although it is advertised: see the diagnostics of the Disparity nodelet";
  return matcher_.describeMismatch();
}

size_t DisparityInput::unmatched() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return matcher_.unmatched();
}

}  // namespace predictive_stereo
