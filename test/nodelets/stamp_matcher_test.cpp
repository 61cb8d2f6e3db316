#include "nodelets/stamp_matcher.h"

#include <gtest/gtest.h>

#include <boost/make_shared.hpp>
#include <stdexcept>

namespace predictive_stereo {
namespace {

constexpr size_t kLeft = 0, kRight = 1, kInfo = 2;

SyncParams exact() {
  SyncParams params;
  params.approximate_sync = false;
  return params;
}

/// A matcher with three slots, and numbers as messages.
class StampMatcherTest : public testing::Test {
 protected:
  std::vector<StampMatcher::Set> add(StampMatcher& matcher, size_t slot, double stamp_s,
                                     int value = 0, bool constant = false) {
    return matcher.add(slot, ros::Time(stamp_s), boost::make_shared<int>(value), constant);
  }
  static int value(const StampMatcher::Message& message) {
    return *boost::static_pointer_cast<const int>(message);
  }

  StampMatcher matcher_{{"left", "right", "info"}, SyncParams()};
  StampMatcher exact_{{"left", "right", "info"}, exact()};
};

TEST_F(StampMatcherTest, joins_as_soon_as_the_last_partner_is_there_in_whatever_order) {
  EXPECT_TRUE(add(exact_, kInfo, 1.0, 3).empty());
  EXPECT_TRUE(add(exact_, kRight, 1.0, 2).empty());
  const auto sets = add(exact_, kLeft, 1.0, 1);
  ASSERT_EQ(sets.size(), 1u);
  EXPECT_EQ(value(sets[0][kLeft]), 1);
  EXPECT_EQ(value(sets[0][kRight]), 2);
  EXPECT_EQ(value(sets[0][kInfo]), 3);
  EXPECT_TRUE(add(exact_, kLeft, 1.0, 1).empty()) << "partners are used once";
}

TEST_F(StampMatcherTest, the_last_slots_may_be_left_out) {
  exact_.use(2);
  EXPECT_TRUE(add(exact_, kLeft, 1.0, 1).empty());
  const auto sets = add(exact_, kRight, 1.0, 2);
  ASSERT_EQ(sets.size(), 1u);
  EXPECT_EQ(sets[0].size(), 2u);
  EXPECT_TRUE(add(exact_, kLeft, 2.0).empty());
  exact_.use(3);
  EXPECT_TRUE(add(exact_, kRight, 2.0).empty()) << "nothing from before";
  EXPECT_TRUE(add(exact_, kLeft, 3.0).empty());
  EXPECT_TRUE(add(exact_, kRight, 3.0).empty());
  EXPECT_EQ(add(exact_, kInfo, 3.0).size(), 1u);
}

TEST_F(StampMatcherTest, exact_means_exact) {
  add(exact_, kLeft, 1.0);
  add(exact_, kInfo, 1.0);
  EXPECT_TRUE(exact_.add(kRight, ros::Time(1, 1), boost::make_shared<int>(0)).empty());
}

TEST_F(StampMatcherTest, differences_up_to_the_tolerance_are_let_pass) {
  add(matcher_, kLeft, 1.0);
  add(matcher_, kInfo, 1.0);
  EXPECT_TRUE(add(matcher_, kRight, 1.0101).empty());
  add(matcher_, kLeft, 2.0);
  add(matcher_, kInfo, 2.0);
  EXPECT_EQ(add(matcher_, kRight, 2.0099).size(), 1u);
}

TEST_F(StampMatcherTest, of_several_partners_the_nearest_is_taken) {
  add(matcher_, kRight, 0.993, 1);
  add(matcher_, kRight, 1.002, 2);
  add(matcher_, kRight, 1.009, 3);
  add(matcher_, kInfo, 1.0);
  const auto sets = add(matcher_, kLeft, 1.0);
  ASSERT_EQ(sets.size(), 1u);
  EXPECT_EQ(value(sets[0][kRight]), 2);
}

TEST_F(StampMatcherTest, a_latched_calibration_belongs_to_all) {
  add(matcher_, kInfo, 0, 7, true);
  for (const double stamp_s : {1.0, 1.1, 1.2}) {
    add(matcher_, kRight, stamp_s);
    const auto sets = add(matcher_, kLeft, stamp_s);
    ASSERT_EQ(sets.size(), 1u);
    EXPECT_EQ(value(sets[0][kInfo]), 7);
  }
}

TEST_F(StampMatcherTest, a_calibration_with_a_stamp_ends_a_latched_one) {
  add(matcher_, kInfo, 0, 7, true);
  add(matcher_, kInfo, 1.0, 8);
  add(matcher_, kRight, 1.0);
  EXPECT_EQ(value(add(matcher_, kLeft, 1.0).at(0)[kInfo]), 8);
  add(matcher_, kRight, 1.1);
  EXPECT_EQ(add(matcher_, kLeft, 1.1).size(), 0u) << "its own is still to come";
  EXPECT_EQ(value(add(matcher_, kInfo, 1.1, 9).at(0)[kInfo]), 9);
}

TEST_F(StampMatcherTest, a_latched_calibration_that_comes_last_completes_all_that_wait) {
  for (const int i : {1, 2, 3}) {
    add(matcher_, kLeft, i, i);
    add(matcher_, kRight, i);
  }
  const auto sets = add(matcher_, kInfo, 0, 7, true);
  ASSERT_EQ(sets.size(), 3u);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(value(sets[i][kLeft]), i + 1) << "oldest first";
}

TEST_F(StampMatcherTest, left_images_without_partners_are_counted_when_given_up) {
  for (const double stamp_s : {1.0, 1.1, 1.2}) {
    add(exact_, kLeft, stamp_s);
    add(exact_, kInfo, stamp_s);
  }
  EXPECT_EQ(exact_.unmatched(), 0u);
  EXPECT_EQ(add(exact_, kRight, 1.2).size(), 1u);
  EXPECT_EQ(exact_.unmatched(), 2u) << "older ones will find no partner any more";
}

TEST_F(StampMatcherTest, what_waits_is_bounded_by_the_queue_size) {
  SyncParams params = exact();
  params.queue_size = 3;
  StampMatcher matcher({"left", "right", "info"}, params);
  for (int i = 1; i <= 5; ++i) add(matcher, kLeft, i);
  EXPECT_EQ(matcher.unmatched(), 2u);
  add(matcher, kRight, 2.0);
  EXPECT_TRUE(add(matcher, kInfo, 2.0).empty());
  add(matcher, kRight, 3.0);
  EXPECT_EQ(add(matcher, kInfo, 3.0).size(), 1u);
}

TEST_F(StampMatcherTest, time_that_goes_back_starts_anew) {
  add(exact_, kLeft, 100.0, 1);
  add(exact_, kRight, 100.0, 1);
  add(exact_, kLeft, 1.0, 2);
  add(exact_, kRight, 1.0, 2);
  const auto sets = add(exact_, kInfo, 1.0, 2);
  ASSERT_EQ(sets.size(), 1u);
  EXPECT_EQ(value(sets[0][kLeft]), 2);
  EXPECT_TRUE(add(exact_, kInfo, 100.0).empty()) << "the end of the last pass is forgotten";
}

// As MovingObjects, which gets a disparity later than its left image.
TEST_F(StampMatcherTest, the_last_set_of_a_pass_is_complete_although_the_next_pass_has_begun) {
  add(exact_, kRight, 100.0, 1);
  add(exact_, kInfo, 100.0, 1);
  add(exact_, kRight, 1.0, 2);
  add(exact_, kInfo, 1.0, 2);
  const auto last = add(exact_, kLeft, 100.0, 1);
  ASSERT_EQ(last.size(), 1u);
  EXPECT_EQ(value(last[0][kRight]), 1);
  const auto first = add(exact_, kLeft, 1.0, 2);
  ASSERT_EQ(first.size(), 1u);
  EXPECT_EQ(value(first[0][kRight]), 2);
  EXPECT_EQ(exact_.unmatched(), 0u);
}

TEST_F(StampMatcherTest, the_last_left_image_of_a_pass_is_counted_if_it_finds_no_partner) {
  add(exact_, kLeft, 100.0);
  for (const size_t slot : {kLeft, kRight, kInfo}) add(exact_, slot, 1.0);
  EXPECT_EQ(exact_.unmatched(), 1u);
}

TEST_F(StampMatcherTest, cleared_it_waits_for_nothing_but_keeps_latched_ones) {
  add(matcher_, kInfo, 0, 7, true);
  add(matcher_, kLeft, 1.0);
  matcher_.use(3);
  EXPECT_TRUE(add(matcher_, kRight, 1.0).empty());
  EXPECT_EQ(add(matcher_, kLeft, 1.0).size(), 1u);
}

TEST_F(StampMatcherTest, says_which_stamps_differ_by_how_much_and_what_cures_it) {
  EXPECT_EQ(matcher_.describeMismatch(), "");
  for (const double stamp_s : {1.0, 1.1}) {
    add(matcher_, kLeft, stamp_s);
    add(matcher_, kInfo, stamp_s + 0.001);
    add(matcher_, kRight, stamp_s + 0.025);
  }
  EXPECT_EQ(matcher_.describeMismatch(),
            "the stamps of right differ from those of left by 25 ms or more, but sync_tolerance "
            "allows 10 ms: set sync_tolerance above the difference, or synchronise the cameras");
  add(exact_, kLeft, 1.0);
  add(exact_, kInfo, 1.0);
  add(exact_, kRight, 1.002);
  EXPECT_EQ(exact_.describeMismatch(),
            "the stamps of right differ from those of left by 2 ms or more, but approximate_sync "
            "is false: set approximate_sync to true");
}

// A tolerance of their difference would join images of two moments.
TEST_F(StampMatcherTest, a_partner_that_comes_after_all_have_left_needs_a_longer_queue) {
  for (int i = 0; i < 20; ++i) {
    add(matcher_, kLeft, 2 + 0.05 * i);
    add(matcher_, kInfo, 2 + 0.05 * i);
    add(matcher_, kRight, 1.3 + 0.05 * i);
  }
  EXPECT_NE(matcher_.describeMismatch().find("by 250 ms or more, but the queues hold less"),
            std::string::npos)
      << matcher_.describeMismatch();
  EXPECT_NE(matcher_.describeMismatch().find("raise queue_size"), std::string::npos);
}

TEST_F(StampMatcherTest, refuses_parameters_outside_their_limits) {
  SyncParams params;
  params.queue_size = 0;
  EXPECT_THROW(StampMatcher({"left"}, params), std::invalid_argument);
  params = SyncParams();
  params.sync_tolerance = -1;
  EXPECT_THROW(StampMatcher({"left"}, params), std::invalid_argument);
}

}  // namespace
}  // namespace predictive_stereo
