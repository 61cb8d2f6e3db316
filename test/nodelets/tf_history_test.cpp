#include <gtest/gtest.h>

#include <boost/make_shared.hpp>
#include <stdexcept>

#include "nodelets/tf_input.h"

namespace predictive_stereo {
namespace {

class TfHistoryTest : public testing::Test {
 protected:
  /// @param x_m  tells which transform is found.
  void add(const std::string& child, double stamp_s, double x_m = 0) {
    const auto transform = boost::make_shared<geometry_msgs::TransformStamped>();
    transform->header.frame_id = "world";
    transform->header.stamp = ros::Time(stamp_s);
    transform->child_frame_id = child;
    transform->transform.translation.x = x_m;
    transform->transform.rotation.w = 1;
    history_.add(transform);
  }
  void addAll(const std::string& child, double from_s, double to_s, double x_m = 0) {
    for (double stamp_s = from_s; stamp_s < to_s + 0.05; stamp_s += 0.1) add(child, stamp_s, x_m);
  }
  bool knows(const std::string& child, double stamp_s) const {
    return buffer_.canTransform("world", child, ros::Time(stamp_s));
  }
  double xAt(const std::string& child, double stamp_s) const {
    return buffer_.lookupTransform("world", child, ros::Time(stamp_s)).transform.translation.x;
  }

  tf2::BufferCore buffer_{ros::Duration(TfHistory::kKept_s)};
  TfHistory history_{buffer_};
};

TEST_F(TfHistoryTest, a_bag_that_starts_again_replaces_frame_after_frame) {
  addAll("base", 100, 105, 1);
  addAll("arm", 100, 105, 1);
  add("base", 100, 2);
  EXPECT_EQ(xAt("base", 100.05), 1) << "one message is not yet believed";
  add("base", 100.1, 2);
  EXPECT_EQ(xAt("base", 100.05), 2);
  EXPECT_FALSE(knows("base", 103)) << "of the pass before";
  EXPECT_TRUE(knows("arm", 103)) << "has not gone back yet";
  addAll("arm", 100, 100.2, 2);
  EXPECT_EQ(xAt("arm", 100.15), 2);
  EXPECT_FALSE(knows("arm", 103));
}

TEST_F(TfHistoryTest, one_message_out_of_order_changes_nothing_and_is_named) {
  addAll("base", 100, 105);
  addAll("arm", 100, 105);
  add("base", 50);
  try {
    add("base", 105.2);
    FAIL() << "nothing was said";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("'base'"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("55.2 s"), std::string::npos) << error.what();
  }
  for (const double stamp_s : {100.0, 103.0, 105.2}) EXPECT_TRUE(knows("base", stamp_s));
  EXPECT_TRUE(knows("arm", 103));
  EXPECT_NO_THROW(add("base", 105.3));
}

TEST_F(TfHistoryTest, one_publisher_with_another_clock_takes_nothing_from_the_others) {
  addAll("base", 100, 105);
  addAll("arm", 10000, 10005);
  addAll("arm", 100, 101);  // its clock was corrected
  EXPECT_TRUE(knows("arm", 100.5));
  EXPECT_FALSE(knows("arm", 10003));
  EXPECT_TRUE(knows("base", 103));
}

TEST_F(TfHistoryTest, after_one_message_of_the_future_the_frame_is_known_again) {
  addAll("base", 100, 105);
  add("base", 100000);
  addAll("base", 105.1, 106);
  EXPECT_TRUE(knows("base", 105.5));
  EXPECT_FALSE(knows("base", 50000));
}

TEST_F(TfHistoryTest, images_that_go_back_confirm_what_came_before_them_and_after) {
  addAll("base", 100, 105, 1);
  addAll("arm", 100, 105, 1);
  add("base", 100.1, 2);
  history_.goBackTo(ros::Time(100));
  EXPECT_EQ(xAt("base", 100.1), 2);
  EXPECT_FALSE(knows("base", 103));
  EXPECT_FALSE(knows("arm", 103));
  add("arm", 105.2, 1);  // the end of the pass before comes late
  add("arm", 100.1, 2);
  EXPECT_EQ(xAt("arm", 100.1), 2);
  EXPECT_FALSE(knows("arm", 105.2));
}

TEST_F(TfHistoryTest, images_that_go_back_leave_frames_that_have_gone_back) {
  addAll("base", 100, 105);
  addAll("base", 50, 50.4);
  history_.goBackTo(ros::Time(50));
  EXPECT_TRUE(knows("base", 50.1));
}

TEST_F(TfHistoryTest, small_steps_back_are_no_new_pass) {
  addAll("base", 100, 105);
  EXPECT_NO_THROW(add("base", 104.7));
  EXPECT_NO_THROW(add("base", 105.1));
  EXPECT_TRUE(knows("base", 101));
}

TEST_F(TfHistoryTest, what_is_late_is_told_from_what_is_absent) {
  addAll("base", 100, 105);
  EXPECT_TRUE(isLate(buffer_, "world", "base", ros::Time(105.3)));
  EXPECT_FALSE(isLate(buffer_, "world", "base", ros::Time(104.9)));
  EXPECT_FALSE(isLate(buffer_, "world", "base", ros::Time(99)));
  EXPECT_FALSE(isLate(buffer_, "nowhere", "base", ros::Time(105.3)));
  geometry_msgs::TransformStamped fixed;
  fixed.header.frame_id = "base";
  fixed.child_frame_id = "camera";
  fixed.transform.rotation.w = 1;
  buffer_.setTransform(fixed, "tf", true);
  EXPECT_TRUE(isLate(buffer_, "world", "camera", ros::Time(105.3)));
  EXPECT_FALSE(isLate(buffer_, "base", "camera", ros::Time(105.3)));
}

TEST_F(TfHistoryTest, the_last_ten_seconds_are_kept) {
  addAll("base", 100, 200);
  addAll("arm", 100, 200);
  addAll("arm", 100, 101);  // fills the buffer again
  EXPECT_TRUE(knows("base", 190.5));
  EXPECT_FALSE(knows("base", 185));
}

}  // namespace
}  // namespace predictive_stereo
