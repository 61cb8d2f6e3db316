/// Disparity with the odometry of others, which comes by tf.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "changed_pairs.h"
#include "evaluation/sequence.h"
#include "nodelets/stereo_messages.h"
#include "posed_camera.h"

namespace predictive_stereo {
namespace {

class ForeignOdometry : public PosedCameraTest {
 protected:
  void SetUp() override {
    setParam("Disparity", "odom_frame", "world_of_others");
    load("Disparity");
    disparity_.emplace(node_, "disparity");
    predicted_.emplace(node_, "predicted_disparity");
    ASSERT_TRUE(player_.waitForSubscribers());
  }
  bool publishesDisparity(const StereoPair& pair) {
    return NodeletTest::publishesDisparity(pair, *disparity_);
  }
  /// Sends the pose, too.
  bool moves(int index) { return publishesDisparity(moved(index, camera_, broadcaster_)); }
  size_t predictedPixels(int index) { return validPixels(*predicted_->at(street().stamp(index))); }

  /// Tests use the same stamps, and share tf.
  const std::string camera_ = ns_.substr(1) + "_camera";
  static constexpr size_t kHalf = StreetCamera::kWidth * StreetCamera::kHeight / 2;
  tf2_ros::TransformBroadcaster broadcaster_;
  std::optional<DisparityRecorder> disparity_, predicted_;
};

TEST_F(ForeignOdometry, anybodys_odometry_serves_through_tf) {
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(moves(i));
  EXPECT_GT(predictedPixels(3), kHalf);
  EXPECT_TRUE(eventually([&] { return value("Disparity", "predicted") == "yes"; }));
}

TEST_F(ForeignOdometry, a_pair_that_is_late_takes_no_tf_from_those_that_follow) {
  std::vector<StereoPair> pairs;
  for (int i = 0; i < 4; ++i) pairs.push_back(moved(i, camera_, broadcaster_));
  geometry_msgs::TransformStamped ahead =
      transformMsg(street().stamp(3), "world_of_others", camera_, Eigen::Isometry3d::Identity());
  ahead.header.stamp += ros::Duration(1);
  broadcaster_.sendTransform(ahead);
  for (int i : {0, 1, 2}) ASSERT_TRUE(publishesDisparity(pairs[i]));
  player_.publish(pairs[1]);
  EXPECT_TRUE(says("Disparity", "older than the one before, and is ignored"));
  ASSERT_TRUE(publishesDisparity(pairs[3]));
  EXPECT_GT(predictedPixels(3), kHalf);
}

TEST_F(ForeignOdometry, tf_that_is_late_is_told) {
  for (int i : {0, 1}) ASSERT_TRUE(moves(i));
  const StereoPair late = withStamp(moved(1, camera_, broadcaster_), street().stamp(2));
  ASSERT_TRUE(publishesDisparity(late));
  EXPECT_TRUE(says("Disparity", "older than the image: raise transform_timeout"));
}

bool allFinite(const stereo_msgs::DisparityImage& disparity) {
  for (size_t i = 0; i < disparity.image.data.size(); i += sizeof(float)) {
    float d;
    std::memcpy(&d, &disparity.image.data[i], sizeof(d));
    if (!std::isfinite(d)) return false;
  }
  return true;
}

TEST_F(ForeignOdometry, a_jump_of_anybodys_odometry_is_told) {
  for (int i : {0, 1, 2}) ASSERT_TRUE(moves(i));
  jump_.translate(Eigen::Vector3d(8, -2, 1))
      .rotate(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()));
  ASSERT_TRUE(moves(3));
  EXPECT_TRUE(allFinite(*disparity_->last()));
  EXPECT_GT(validPixels(*disparity_->last()), kHalf);
  EXPECT_TRUE(says("Disparity", "contradict the prediction by the motion of odom_frame"))
      << value("Disparity", "prediction contradicted [%]") << " % are contradicted; predicted are "
      << predictedPixels(3) << " pixels";
  // From now on all poses have the jump, which does not affect their differences.
  for (int i : {4, 5}) ASSERT_TRUE(moves(i));
  EXPECT_GT(predictedPixels(5), kHalf);
  EXPECT_TRUE(eventually(
      [&] { return !diagnostics_.says(ns_.substr(1) + "/Disparity", "contradict"); }, 10));
}

TEST_F(ForeignOdometry, tf_that_is_not_a_number_is_told) {
  for (int i : {0, 1}) ASSERT_TRUE(moves(i));
  const Eigen::Isometry3d good = jump_;
  jump_.translation().x() = std::nan("");
  ASSERT_TRUE(moves(2));
  EXPECT_TRUE(allFinite(*disparity_->last()));
  EXPECT_EQ(predictedPixels(2), 0u);
  EXPECT_TRUE(says("Disparity", "relative to odom_frame 'world_of_others'"));
  jump_ = good;
  for (int i : {3, 4}) ASSERT_TRUE(moves(i));
  EXPECT_TRUE(allFinite(*disparity_->last()));
  EXPECT_GT(predictedPixels(4), kHalf);
}

// Share of the pixels known in both maps that differ by less than a pixel.
double agreement(const stereo_msgs::DisparityImage& a, const stereo_msgs::DisparityImage& b) {
  size_t known = 0, agree = 0;
  for (size_t i = 0; i < a.image.data.size(); i += sizeof(float)) {
    float of_a, of_b;
    std::memcpy(&of_a, &a.image.data[i], sizeof(of_a));
    std::memcpy(&of_b, &b.image.data[i], sizeof(of_b));
    if (of_a < a.min_disparity || of_b < b.min_disparity) continue;
    ++known;
    agree += std::abs(of_a - of_b) < 1;
  }
  return static_cast<double>(agree) / static_cast<double>(std::max<size_t>(known, 1));
}

TEST_F(ForeignOdometry, kittis_poses_serve_through_tf) {
  const char* kitti = std::getenv("KITTI_EXCERPTS");
  if (!kitti) GTEST_SKIP() << "KITTI_EXCERPTS is not set";
  const auto drive =
      kittiDriveSequence(kitti + std::string("/2011_09_30"), "2011_09_30_drive_0020_sync");
  const auto T_world_cam = drive->poses();
  ASSERT_TRUE(T_world_cam);
  const DisparityRecorder measured(node_, "measured_disparity");
  ros::Time stamp;
  for (int i = 0; i < 4; ++i) {
    stamp.fromSec(drive->stamp_s(i));
    broadcaster_.sendTransform(
        transformMsg(stamp, "world_of_others", StreetCamera::kFrame, (*T_world_cam)[i]));
    const SequenceFrame frame = drive->frame(i);
    ASSERT_TRUE(publishesDisparity(
        {street().image(frame.left, stamp), street().image(frame.right, stamp),
         cameraInfo(drive->rig(), stamp, false), cameraInfo(drive->rig(), stamp, true)}));
  }
  ASSERT_TRUE(eventually([&] { return predicted_->at(stamp) && measured.at(stamp); }));
  EXPECT_GT(validPixels(*predicted_->at(stamp)), drive->rig().size.area() / 2u);
  EXPECT_GT(agreement(*predicted_->at(stamp), *measured.at(stamp)), 0.8);
}

}  // namespace
}  // namespace predictive_stereo

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "foreign_odometry_test");
  ros::AsyncSpinner spinner(2);
  spinner.start();
  return RUN_ALL_TESTS();
}
