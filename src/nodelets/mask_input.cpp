#include "nodelets/mask_input.h"

#include <utility>

#include "nodelets/stereo_messages.h"

namespace predictive_stereo {

MaskInput::MaskInput(const ros::NodeHandle& node, Health& health, Arrivals& arrivals,
                     Callback on_mask)
    : node_(node), health_(health), arrivals_(arrivals), on_mask_(std::move(on_mask)) {}

void MaskInput::listenTo(const std::string& topic) {
  if (topic == topic_) return;
  topic_ = topic;
  silent_ = false;
  if (topic.empty())
    subscription_.shutdown();
  else
    subscription_.replace(subscribe<sensor_msgs::Image>(
        node_, health_, topic, 2, [this](const sensor_msgs::ImageConstPtr& mask) { add(mask); }));
  if (topic.empty()) forget();
}

void MaskInput::forget() {
  const std::lock_guard<std::mutex> lock(mutex_);
  mask_.reset();
}

sensor_msgs::ImageConstPtr MaskInput::at(ros::Time stamp) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return mask_ && mask_->header.stamp == stamp ? mask_ : nullptr;
}

sensor_msgs::ImageConstPtr MaskInput::waitForMask(ros::Time stamp, double timeout_s) {
  const bool expected = isPublished() && !silent_;
  auto mask = arrivals_.waitFor(expected ? timeout_s : 0.0, [&] { return at(stamp); });
  if (expected && !mask) silent_ = true;
  return mask;
}

cv::Mat1b MaskInput::usable(const sensor_msgs::ImageConstPtr& mask,
                            const sensor_msgs::Image& left) {
  cv::Mat1b view;
  if (mask) health_.guard(kTopic, [&] { view = movedMask(*mask, left); });
  return view;
}

void MaskInput::add(const sensor_msgs::ImageConstPtr& mask) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    mask_ = mask;
  }
  silent_ = false;
  arrivals_.notify();
  if (on_mask_) on_mask_(mask);
}

}  // namespace predictive_stereo
