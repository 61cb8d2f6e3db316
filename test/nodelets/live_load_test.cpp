/// The nodelets under load: what is lost is counted, latency stays bounded, memory does not grow.
#include "tools/live_load.h"

#include <gtest/gtest.h>
#include <ros/ros.h>

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <memory>

#include "evaluation/kitti_fixture.h"

namespace predictive_stereo {
namespace {

double median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
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

// Seldom a frame is lost although there was room for it: where the machine has so much else to do
// that a thread which has just been woken does not run for the time of a whole frame.
TEST_F(LiveLoadTest, without_haste_hardly_a_frame_is_lost_and_memory_does_not_grow) {
  const LiveLoadResult result = load_->run(0, 500, AllNodeletParams());
  EXPECT_EQ(result.sent, 500);
  EXPECT_LE(result.lost(), 25);
  EXPECT_EQ(result.lost(), result.reported_losses);
  // Frames of 320x96 take some 10 ms: this fails where they wait for a time-out.
  EXPECT_LT(median(result.latency_ms), 150);
  EXPECT_LT(result.growth_percent(), 2.0)
      << result.early_bytes << " bytes after 100 frames, " << result.late_bytes << " at the end";
}

TEST_F(LiveLoadTest, in_haste_the_newest_is_taken_and_every_loss_is_counted) {
  AllNodeletParams params;
  // A message that ROS throws away is one that nobody can count.
  params.ego_motion.sync.queue_size = params.disparity.sync.queue_size = 1000;
  params.moving_objects.queue_size = 1000;
  const LiveLoadResult result = load_->run(400, 1000, params);
  EXPECT_EQ(result.sent, 1000);
  ASSERT_GE(result.latency_ms.size(), 5u);
  EXPECT_GT(result.lost(), 0) << "400 Hz were no haste";
  EXPECT_EQ(result.lost(), result.reported_losses);
  // In a queue that grows they would come to seconds.
  EXPECT_LT(median(result.latency_ms), 1000);
}

}  // namespace
}  // namespace predictive_stereo

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "live_load_test");
  return RUN_ALL_TESTS();
}
