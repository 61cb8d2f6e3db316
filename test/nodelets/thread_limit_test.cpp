#include "nodelets/thread_limit.h"

#include <gtest/gtest.h>

#include <opencv2/core/utility.hpp>

namespace predictive_stereo {
namespace {

TEST(ThreadLimit, TheLeastOfSeveralHolds) {
  cv::setNumThreads(6);
  limitThreads(0);
  EXPECT_EQ(cv::getNumThreads(), 6);
  limitThreads(3);
  EXPECT_EQ(cv::getNumThreads(), 3);
  limitThreads(5);
  limitThreads(0);
  EXPECT_EQ(cv::getNumThreads(), 3);
  limitThreads(2);
  EXPECT_EQ(cv::getNumThreads(), 2);
}

}  // namespace
}  // namespace predictive_stereo
