#include <gtest/gtest.h>

#include "nodelets/tf_output.h"

namespace predictive_stereo {
namespace {

geometry_msgs::TransformStamped transform(const std::string& parent, const std::string& child,
                                          double stamp_s = 1) {
  geometry_msgs::TransformStamped result;
  result.header.frame_id = parent;
  result.header.stamp.fromSec(stamp_s);
  result.child_frame_id = child;
  result.transform.rotation.w = 1;
  return result;
}

TEST(TfRivals, our_own_transforms_are_no_rivals) {
  TfRivals rivals;
  for (int i = 0; i < 3000; ++i) {
    rivals.addOwnTransform(transform("odom", "base_link", i));
    rivals.addTransform(transform("odom", "base_link", i), "/manager", false);
  }
  EXPECT_EQ(rivals.reasonNotToMove("base_link"), "");
}

TEST(TfRivals, one_of_the_same_names_and_process_is_a_rival) {
  TfRivals rivals;
  rivals.addOwnTransform(transform("odom", "base_link", 1));
  rivals.addTransform(transform("odom", "base_link", 1.001), "/manager", false);
  ASSERT_TRUE(rivals.rivalOf("base_link"));
  EXPECT_EQ(rivals.rivalOf("base_link")->publisher, "/manager");
  EXPECT_NE(
      rivals.reasonNotToMove("base_link").find("/manager already moves 'base_link' in 'odom'"),
      std::string::npos);
}

TEST(TfRivals, others_may_move_other_frames) {
  TfRivals rivals;
  rivals.addTransform(transform("base_link", "wheel"), "/joints", false);
  rivals.addTransform(transform("base_link", "camera"), "/robot", true);
  rivals.addTransform(transform("map", "odom"), "/slam", false);
  EXPECT_EQ(rivals.reasonNotToMove("base_link"), "");
}

TEST(TfRivals, slashes_at_the_beginning_do_not_count) {
  TfRivals rivals;
  rivals.addTransform(transform("/odom", "/base_link"), "/old", false);
  EXPECT_NE(rivals.reasonNotToMove("base_link"), "");
}

TEST(TfRivals, a_fixed_frame_is_cured_by_its_root) {
  TfRivals rivals;
  rivals.addTransform(transform("camera_link", "camera_optical"), "/robot", true);
  rivals.addTransform(transform("base_footprint", "camera_link"), "/robot", true);
  EXPECT_NE(rivals.reasonNotToMove("camera_optical").find("Set base_frame to 'base_footprint'"),
            std::string::npos)
      << rivals.reasonNotToMove("camera_optical");
  // A loop of frames must not cause an endless loop.
  rivals.addTransform(transform("camera_optical", "base_footprint"), "/robot", true);
  EXPECT_NE(rivals.reasonNotToMove("camera_optical"), "");
}

}  // namespace
}  // namespace predictive_stereo
