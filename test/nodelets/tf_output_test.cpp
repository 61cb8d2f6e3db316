#include "nodelets/tf_output.h"

#include <gtest/gtest.h>

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

TEST(TfOutput, our_own_transforms_are_no_rivals) {
  TfOutput rivals;
  for (int i = 0; i < 3000; ++i) {
    rivals.addOwnTransform(transform("odom", "base_link", i));
    rivals.addTransform(transform("odom", "base_link", i), "/manager", false);
  }
  EXPECT_EQ(rivals.reasonNotToMove("base_link"), "");
}

TEST(TfOutput, one_of_the_same_names_and_process_is_a_rival) {
  TfOutput rivals;
  rivals.addOwnTransform(transform("odom", "base_link", 1));
  rivals.addTransform(transform("odom", "base_link", 1.001), "/manager", false);
  EXPECT_NE(
      rivals.reasonNotToMove("base_link").find("/manager already moves 'base_link' in 'odom'"),
      std::string::npos);
}

TEST(TfOutput, others_may_move_other_frames) {
  TfOutput rivals;
  rivals.addTransform(transform("base_link", "wheel"), "/joints", false);
  rivals.addTransform(transform("base_link", "camera"), "/robot", true);
  rivals.addTransform(transform("map", "odom"), "/slam", false);
  EXPECT_EQ(rivals.reasonNotToMove("base_link"), "");
}

TEST(TfOutput, slashes_at_the_beginning_do_not_count) {
  TfOutput rivals;
  rivals.addTransform(transform("/odom", "/base_link"), "/old", false);
  EXPECT_NE(rivals.reasonNotToMove("base_link"), "");
}

TEST(TfOutput, a_fixed_frame_is_cured_by_its_root) {
  TfOutput rivals;
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
