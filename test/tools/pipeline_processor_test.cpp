#include "tools/pipeline_processor.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "nodelets/changed_pairs.h"
#include "nodelets/street_camera.h"

namespace predictive_stereo {
namespace {

const StreetCamera& street() {
  static const StreetCamera street(3);
  return street;
}

void addExtrinsic(tf2::BufferCore& tf, ros::Time stamp) {
  geometry_msgs::TransformStamped extrinsic = street().extrinsic();
  extrinsic.header.stamp = stamp;
  tf.setTransform(extrinsic, "test", false);
}

// The processors of ego-motion and objects have not seen the frame that failed.
TEST(PipelineProcessor, after_a_frame_that_failed_the_next_one_is_the_first) {
  tf2::BufferCore tf;
  PipelineProcessor processor{AllNodeletParams(), tf};
  addExtrinsic(tf, street().stamp(0));
  ASSERT_TRUE(processor.process(street().pair(0)));
  EXPECT_THROW(processor.process(street().pair(1)), std::invalid_argument);  // no extrinsic
  const auto again = processor.process(street().pair(0));
  ASSERT_TRUE(again);
  EXPECT_FALSE(again->disparity.predicted);
  addExtrinsic(tf, street().stamp(1));
  const auto next = processor.process(street().pair(1));
  ASSERT_TRUE(next);
  EXPECT_TRUE(next->disparity.predicted);
}

TEST(PipelineProcessor, a_stamp_that_ros_cannot_compute_with_is_refused_and_changes_nothing) {
  tf2::BufferCore tf;
  PipelineProcessor processor{AllNodeletParams(), tf};
  for (const int frame : {0, 1}) addExtrinsic(tf, street().stamp(frame));
  ASSERT_TRUE(processor.process(street().pair(0)));
  for (const uint32_t sec : {2147483648u, 4200000000u, 4294967295u})
    EXPECT_THROW(processor.process(withStamp(street().pair(1), ros::Time(sec, 999999999))),
                 std::invalid_argument);
  const auto next = processor.process(street().pair(1));
  ASSERT_TRUE(next);
  EXPECT_TRUE(next->disparity.predicted);
}

// tf2 looks up no frame whose name begins with a slash.
TEST(PipelineProcessor, odometry_has_the_names_that_its_frames_have_in_tf) {
  tf2::BufferCore tf;
  AllNodeletParams params;
  params.ego_motion.base_frame = "/" + params.ego_motion.base_frame;
  params.ego_motion.odom_frame = params.disparity.odom_frame = "/robot/odom";
  PipelineProcessor processor{params, tf};
  addExtrinsic(tf, street().stamp(0));
  const auto frame = processor.process(street().pair(0));
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->ego_motion.odometry->header.frame_id, "robot/odom");
  EXPECT_EQ(frame->ego_motion.odometry->child_frame_id, "base_link");
  EXPECT_EQ(frame->ego_motion.pose->header.frame_id, "robot/odom");
}

TEST(PipelineProcessor, refuses_frames_that_make_no_sense_and_names_them) {
  tf2::BufferCore tf;
  addExtrinsic(tf, street().stamp(0));
  const auto refusal = [&](const AllNodeletParams& params, const StereoPair& pair) -> std::string {
    try {
      PipelineProcessor(params, tf).process(pair);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "accepted";
  };
  const StereoPair pair = street().pair(0);
  AllNodeletParams params;
  EXPECT_EQ(refusal(params, pair), "accepted");
  params.ego_motion.odom_frame = "/base_link";
  EXPECT_NE(refusal(params, pair).find("'/base_link' is the frame that moves in it"),
            std::string::npos);
  auto nameless = boost::make_shared<sensor_msgs::Image>(*pair.left);
  nameless->header.frame_id.clear();
  EXPECT_NE(refusal(AllNodeletParams(), {nameless, pair.right, pair.left_info, pair.right_info})
                .find("has an empty frame_id"),
            std::string::npos);
}

}  // namespace
}  // namespace predictive_stereo
