#include "nodelets/threads.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

namespace predictive_stereo {
namespace {

using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

// roscpp counts as running only between init and shutdown.
class ArrivalsTest : public testing::Test {
 protected:
  ArrivalsTest() { ros::init(ros::M_string(), "threads_test", ros::init_options::NoSigintHandler); }

  Arrivals arrivals_;
};

TEST_F(ArrivalsTest, what_is_there_is_not_waited_for) {
  const auto begin = Clock::now();
  EXPECT_EQ(arrivals_.waitFor(60, [] { return 5; }), 5);
  EXPECT_LT(secondsSince(begin), 10);
}

TEST_F(ArrivalsTest, each_arrival_asks_again_and_nothing_else_does) {
  std::atomic<int> asked{0}, arrived{0};
  std::thread waiter([&] {
    EXPECT_TRUE(arrivals_.waitFor(60, [&] {
      ++asked;
      return arrived == 3;
    }));
  });
  for (int i = 0; i < 3; ++i) {
    while (asked <= i) std::this_thread::yield();
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    EXPECT_EQ(asked, i + 1) << "asked without an arrival";
    ++arrived;
    arrivals_.notify();
  }
  waiter.join();
  EXPECT_EQ(asked, 4);
}

TEST_F(ArrivalsTest, an_arrival_while_asking_is_not_lost) {
  int asked = 0;
  const auto begin = Clock::now();
  EXPECT_TRUE(arrivals_.waitFor(60, [&] {
    if (++asked == 1) arrivals_.notify();
    return asked == 2;
  }));
  EXPECT_LT(secondsSince(begin), 10);
}

TEST_F(ArrivalsTest, it_ends_at_the_deadline) {
  const auto begin = Clock::now();
  EXPECT_FALSE(arrivals_.waitFor(0.05, [] { return false; }));
  EXPECT_GE(secondsSince(begin), 0.05);
  for (const double timeout_s : {0.0, -1.0}) {
    int asked = 0;
    EXPECT_FALSE(arrivals_.waitFor(timeout_s, [&] {
      ++asked;
      arrivals_.notify();
      return false;
    }));
    EXPECT_EQ(asked, 1);
  }
}

TEST_F(ArrivalsTest, stop_ends_waits_and_later_ones) {
  std::atomic<bool> asked{false};
  std::thread waiter([&] {
    EXPECT_FALSE(arrivals_.waitFor(3600, [&] {
      asked = true;
      return false;
    }));
  });
  while (!asked) std::this_thread::yield();
  arrivals_.stop();
  waiter.join();
  EXPECT_FALSE(arrivals_.waitFor(3600, [] { return false; }));
}

class FrameWorkerTest : public ArrivalsTest {
 protected:
  // Until the worker has taken the job and has done so much with it.
  static void until(const std::atomic<int>& count, int value) {
    while (count < value) std::this_thread::yield();
  }
  std::vector<int> done_;
  std::atomic<int> started_{0}, finished_{0};
  std::atomic<bool> free_{false};
};

TEST_F(FrameWorkerTest, keeps_the_newest_job_while_it_works) {
  FrameWorker<int> worker(
      [&](int job) {
        ++started_;
        while (!free_) std::this_thread::yield();
        done_.push_back(job);
        ++finished_;
      },
      arrivals_);
  worker.push(0);
  until(started_, 1);
  for (int job = 1; job <= 5; ++job) worker.push(job);
  free_ = true;
  until(finished_, 2);
  worker.stop();
  EXPECT_EQ(done_, (std::vector<int>{0, 5}));
  EXPECT_EQ(worker.dropped(), 4u);
}

// As with tf that is late: each frame is ready, only later.
TEST_F(FrameWorkerTest, keeps_all_jobs_while_it_waits_for_other_nodes) {
  FrameWorker<int> worker(
      [&](int job) {
        ++started_;
        arrivals_.waitFor(60, [&] { return free_.load(); });
        done_.push_back(job);
        ++finished_;
      },
      arrivals_);
  worker.push(0);
  while (!arrivals_.isWaiting()) std::this_thread::yield();
  for (int job = 1; job <= 3; ++job) worker.push(job);
  free_ = true;
  arrivals_.notify();
  until(finished_, 4);
  worker.stop();
  EXPECT_EQ(done_, (std::vector<int>{0, 1, 2, 3}));
  EXPECT_EQ(worker.dropped(), 0u);
}

// Otherwise latency would grow to that of all jobs that came while it waited.
TEST_F(FrameWorkerTest, keeps_the_newest_job_if_its_work_takes_longer_than_jobs_to_arrive) {
  std::atomic<int> newest{0};
  std::vector<int> lags;  // jobs that were newer than the one that is taken
  FrameWorker<int> worker(
      [&](int job) {
        lags.push_back(newest - job);
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        arrivals_.waitFor(0.02, [] { return false; });
      },
      arrivals_);
  for (int job = 0; job < 100; ++job) {
    newest = job;
    worker.push(job);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  worker.stop();
  ASSERT_GE(lags.size(), 4u);
  std::sort(lags.begin(), lags.end());
  EXPECT_LE(lags[lags.size() / 2], 1);
}

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
