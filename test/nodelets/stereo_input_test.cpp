/// Images that arrive while a nodelet's callbacks have to wait.
#include <gtest/gtest.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>

#include <boost/make_shared.hpp>
#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include "nodelets/synced_topics.h"

namespace predictive_stereo {
namespace {

constexpr int kFrames = 60;

template <class Message>
boost::shared_ptr<Message> stamped(int frame) {
  auto message = boost::make_shared<Message>();
  message->header.stamp = ros::Time(100 + 0.1 * frame);
  return message;
}

class StereoInputTest : public testing::Test {
 protected:
  StereoInputTest() {
    waiting_.setCallbackQueue(&queue_);
    input_ = std::make_unique<SyncedTopics>(
        waiting_, health_, SyncParams(), StereoInput::topics(), StereoInput::cures(),
        [this](const SyncedTopics::Set& set) { pairs_.push_back(StereoInput::frame(set)); });
    input_->start(StereoInput::topics().size());
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while ((left_.getNumSubscribers() == 0 || right_.getNumSubscribers() == 0 ||
            left_info_.getNumSubscribers() == 0 || right_info_.getNumSubscribers() == 0) &&
           std::chrono::steady_clock::now() < deadline)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }

  // In one process a message is in the subscriber's queue when publish() returns.
  void send(int frame) {
    left_info_.publish(stamped<sensor_msgs::CameraInfo>(frame));
    right_info_.publish(stamped<sensor_msgs::CameraInfo>(frame));
    left_.publish(stamped<sensor_msgs::Image>(frame));
    if (frame != lost_right_) right_.publish(stamped<sensor_msgs::Image>(frame));
  }

  ros::NodeHandle node_, waiting_;
  ros::CallbackQueue queue_;
  ros::Publisher left_ = node_.advertise<sensor_msgs::Image>("left/image_rect", 5),
                 right_ = node_.advertise<sensor_msgs::Image>("right/image_rect", 5),
                 left_info_ = node_.advertise<sensor_msgs::CameraInfo>("left/camera_info", 5),
                 right_info_ = node_.advertise<sensor_msgs::CameraInfo>("right/camera_info", 5);
  Health health_{node_, ros::NodeHandle("~"), "/test", "StereoInput", [] { return std::string(); }};
  std::vector<StereoPair> pairs_;
  int lost_right_ = -1;
  std::unique_ptr<SyncedTopics> input_;
};

TEST_F(StereoInputTest, nothing_is_lost_uncounted_while_callbacks_wait) {
  for (int i = 0; i < kFrames; ++i) send(i);
  EXPECT_TRUE(pairs_.empty());
  queue_.callAvailable();
  EXPECT_EQ(pairs_.size(), static_cast<size_t>(kFrames));
  EXPECT_EQ(input_->unmatched(), 0u);
}

TEST_F(StereoInputTest, left_images_without_a_right_one_are_counted) {
  lost_right_ = 40;
  for (int i = 0; i < kFrames; ++i) send(i);
  queue_.callAvailable();
  EXPECT_EQ(pairs_.size(), static_cast<size_t>(kFrames - 1));
  EXPECT_EQ(input_->unmatched(), 1u);
}

}  // namespace
}  // namespace predictive_stereo

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "stereo_input_test");
  return RUN_ALL_TESTS();
}
