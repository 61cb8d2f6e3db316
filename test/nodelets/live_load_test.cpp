/// The nodelets under load: what is lost is counted, latency stays bounded, memory does not grow.
#include "tools/live_load.h"

#include <gtest/gtest.h>
#include <ros/ros.h>

#include <algorithm>
#include <cstdlib>
#include <memory>

#include "evaluation/kitti_fixture.h"

namespace predictive_stereo {
namespace {

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

TEST_F(LiveLoadTest, without_haste_nothing_is_lost_and_memory_does_not_grow) {
  const LiveLoadResult result = load_->run(0, 500, AllNodeletParams());
  EXPECT_EQ(result.sent, 500);
  EXPECT_EQ(result.lost(), 0);
  EXPECT_EQ(result.reported_losses, 0);
  ASSERT_EQ(result.latency_ms.size(), 490u);
  // Frames of 320x96 take a few milliseconds: this fails where something waits for a time-out.
  EXPECT_LT(*std::max_element(result.latency_ms.begin(), result.latency_ms.end()), 1000);
  EXPECT_LT(result.growth_percent(), 2.0)
      << result.early_bytes << " bytes after 100 frames, " << result.late_bytes << " at the end";
}

TEST_F(LiveLoadTest, in_haste_the_newest_is_taken_and_every_loss_is_counted) {
  AllNodeletParams params;
  // A message that ROS throws away is one that nobody can count.
  params.ego_motion.sync.queue_size = params.disparity.sync.queue_size = 400;
  params.moving_objects.queue_size = 400;
  const LiveLoadResult result = load_->run(400, 400, params);
  EXPECT_EQ(result.sent, 400);
  EXPECT_GT(result.processed, 20);
  EXPECT_GT(result.lost(), 0) << "400 Hz were no haste";
  EXPECT_EQ(result.lost(), result.reported_losses);
  // Queues that grow would add up to seconds.
  EXPECT_LT(*std::max_element(result.latency_ms.begin(), result.latency_ms.end()), 1000);
}

}  // namespace
}  // namespace predictive_stereo

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "live_load_test");
  return RUN_ALL_TESTS();
}
