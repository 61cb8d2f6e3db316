#include "tools/progress.h"

#include <gtest/gtest.h>

namespace predictive_stereo {
namespace {

TEST(Progress, tells_the_share_the_count_and_what_is_left) {
  EXPECT_EQ(progressText("replay", 30, 120, 25),
            "replay  [#####...............]   25 %  30 of 120  1:15 left");
  EXPECT_EQ(progressText("replay", 1, 7201, 1.0),
            "replay  [....................]    0 %  1 of 7201  2:00:00 left");
}

TEST(Progress, says_nothing_of_what_is_left_where_it_cannot_know) {
  EXPECT_EQ(progressText("a", 0, 4, 60), "a  [....................]    0 %  0 of 4");
  EXPECT_EQ(progressText("a", 2, 4, 0.1), "a  [##########..........]   50 %  2 of 4");
}

TEST(Progress, says_at_the_end_how_long_it_took) {
  EXPECT_EQ(progressText("a", 4, 4, 61), "a  [####################]  100 %  4 of 4  in 1:01");
}

TEST(Progress, bears_counts_that_are_wrong) {
  EXPECT_EQ(progressText("a", 9, 4, 61), progressText("a", 4, 4, 61));
  EXPECT_EQ(progressText("a", 1, 0, 2), progressText("a", 1, 1, 2));
}

}  // namespace
}  // namespace predictive_stereo
