/// The nodelets under load: lost frames are counted, latency is bounded, memory does not grow.
#include "tools/live_load.h"

#include <diagnostic_msgs/DiagnosticArray.h>
#include <gtest/gtest.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <tf2_msgs/TFMessage.h>

#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "tools/kitti_fixture.h"

namespace predictive_stereo {
namespace {

TEST(LiveLoadResultTest, a_part_of_a_run_is_summed_up_without_the_rest) {
  LiveLoadResult result;
  for (int i = 0; i < 300; ++i) {
    LoadedFrame frame;
    // Every tenth frame of the second hundred is lost; the others take 1 ... 100 ms, not in order.
    if (i < 100 || i >= 200)
      frame.latency_ms = 1000;
    else if (i % 10 != 0)
      frame.latency_ms = i * 37 % 100 + 1;
    frame.resident_bytes = 1000 + i;
    result.frames.push_back(frame);
  }
  const LoadSummary part = result.summary(100, 200);
  EXPECT_EQ(part.sent, 100);
  EXPECT_EQ(part.lost, 10);
  EXPECT_NEAR(part.p50_ms, 51, 1);
  EXPECT_NEAR(part.p95_ms, 96, 1);
  EXPECT_NEAR(part.p99_ms, 100, 1);
  EXPECT_EQ(part.max_ms, 100);
  EXPECT_EQ(part.resident_bytes, 1199);
  EXPECT_EQ(result.summary().sent, 300);
  EXPECT_EQ(result.summary().max_ms, 1000);
  EXPECT_EQ(result.summary(0, 0).p99_ms, 0);
}

TEST(LiveLoadResultTest, the_rate_counts_only_what_came_out) {
  LiveLoadResult result;
  EXPECT_EQ(result.reachedHz(), 0);
  for (int i = 0; i < 10; ++i) {  // ten a second
    LoadedFrame frame;
    frame.sent_s = 0.1 * i;
    result.frames.push_back(frame);
  }
  EXPECT_EQ(result.reachedHz(), 0) << "all are lost";
  // The first one comes at once. The other nine need 0.9 s to be sent.
  result.frames.front().latency_ms = 20;
  EXPECT_NEAR(result.reachedHz(), 1 / 0.9, 1e-9);
  for (LoadedFrame& frame : result.frames) frame.latency_ms = 100;
  EXPECT_NEAR(result.reachedHz(), 10, 1e-9);
}

class LiveLoadTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const TemporaryDirectory folder;
    const std::string bag = folder.path("street.bag");
    const std::string command =
        std::string(STREET_TO_BAG) + " " + bag + " --frames 12 --size 320x96 > /dev/null 2>&1";
    ASSERT_EQ(std::system(command.c_str()), 0);
    load_ = std::make_unique<LiveLoad>(bag, StereoTopicChoice(), 12);
  }
  static void TearDownTestSuite() { load_.reset(); }

  static std::unique_ptr<LiveLoad> load_;
};
std::unique_ptr<LiveLoad> LiveLoadTest::load_;

// A frame may be lost although there was room for it, if the machine is so busy that a woken thread
// does not run for the time of a whole frame.
TEST_F(LiveLoadTest, without_haste_hardly_a_frame_is_lost_and_memory_does_not_grow) {
  const LiveLoadResult result = load_->run(0, 500, AllNodeletParams());
  const LoadSummary all = result.summary();
  EXPECT_EQ(all.sent, 500);
  EXPECT_LE(all.lost, 25);
  EXPECT_EQ(all.lost, result.reported_losses);
  // Frames of 320x96 take about 10 ms, so this fails if they wait for a timeout.
  EXPECT_LT(all.p50_ms, 150);
  const int64_t early_bytes = result.summary(0, 100).resident_bytes;
  EXPECT_LT(static_cast<double>(all.resident_bytes), 1.02 * static_cast<double>(early_bytes))
      << "after 100 frames " << early_bytes;
}

TEST_F(LiveLoadTest, in_haste_the_newest_is_taken_and_every_loss_is_counted) {
  AllNodeletParams params;
  // Messages that ROS drops cannot be counted.
  params.ego_motion.sync.queue_size = params.disparity.sync.queue_size = 1000;
  params.moving_objects.queue_size = 1000;
  const LiveLoadResult result = load_->run(400, 1000, params);
  const LoadSummary all = result.summary();
  EXPECT_EQ(all.sent, 1000);
  ASSERT_LE(all.lost, 995);
  EXPECT_GT(all.lost, 0) << "400 Hz were no haste";
  EXPECT_EQ(all.lost, result.reported_losses);
  // In a growing queue latencies would reach seconds.
  EXPECT_LT(all.p50_ms, 1000);
}

// A robot may run on the same master, with the same camera.
TEST_F(LiveLoadTest, a_robot_on_the_same_master_is_left_alone) {
  ros::NodeHandle robot;
  diagnostic_msgs::DiagnosticArray losses;
  losses.status.resize(1);
  losses.status[0].name = "camera/disparity: matching";
  losses.status[0].values.resize(1);
  losses.status[0].values[0].key = "dropped pairs";
  losses.status[0].values[0].value = "1000";
  ros::Publisher diagnostics =
      robot.advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", 1, true);
  diagnostics.publish(losses);
  ros::CallbackQueue queue;
  robot.setCallbackQueue(&queue);
  int read = 0, written = 0;
  const ros::Publisher fixed = robot.advertise<tf2_msgs::TFMessage>(
      "/tf_static", 1, [&](const ros::SingleSubscriberPublisher&) { ++read; });
  const ros::Subscriber moving = robot.subscribe<tf2_msgs::TFMessage>(
      "/tf", 100, [&](const tf2_msgs::TFMessageConstPtr&) { ++written; });
  EXPECT_LT(load_->run(0, 20, AllNodeletParams()).reported_losses, 1000);
  queue.callAvailable();
  EXPECT_EQ(read, 0);
  EXPECT_EQ(written, 0);
  std::vector<std::string> params;
  ros::param::getParamNames(params);
  for (const std::string& name : params) EXPECT_NE(name.rfind("/live_load_", 0), 0u) << name;
}

}  // namespace
}  // namespace predictive_stereo

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "live_load_test");
  return RUN_ALL_TESTS();
}
