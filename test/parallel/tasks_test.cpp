#include "parallel/tasks.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <opencv2/core/utility.hpp>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace predictive_stereo {
namespace {

class TasksOn : public testing::TestWithParam<int> {
 protected:
  void SetUp() override { cv::setNumThreads(GetParam()); }
  void TearDown() override { cv::setNumThreads(threads_before_); }

 private:
  int threads_before_ = cv::getNumThreads();
};

TEST_P(TasksOn, ALoopCallsEachIndexOnce) {
  std::vector<std::atomic<int>> calls(1000);
  parallelFor({100, 1000}, [&](const cv::Range& part) {
    EXPECT_LT(part.start, part.end);
    for (int i = part.start; i < part.end; ++i) ++calls[static_cast<size_t>(i)];
  });
  for (size_t i = 0; i < calls.size(); ++i) EXPECT_EQ(calls[i], i >= 100) << i;
  parallelForEach(100, [&](int i) { ++calls[static_cast<size_t>(i)]; });
  for (size_t i = 0; i < calls.size(); ++i) EXPECT_EQ(calls[i], 1) << i;
}

TEST_P(TasksOn, ALoopMakesAtMostTheAllowedParts) {
  std::atomic<int> parts{0}, indices{0};
  const auto count = [&](const cv::Range& part) {
    ++parts;
    indices += part.size();
  };
  parallelFor({0, 100}, count, 3);
  EXPECT_LE(parts, 3);
  EXPECT_EQ(indices, 100);
  parallelFor({0, 0}, count);
  parallelFor({5, 2}, count);
  EXPECT_EQ(indices, 100);
}

TEST_P(TasksOn, LoopsPassExceptionsOnAndMayBeUsedAgain) {
  const auto fail = [](const cv::Range& part) {
    if (part.start <= 50 && 50 < part.end) throw std::runtime_error("index 50");
  };
  EXPECT_THROW(parallelFor({0, 100}, fail), std::runtime_error);
  EXPECT_NO_THROW(parallelFor({0, 50}, fail));
}

TEST_P(TasksOn, LoopsWorkWithinLoopsAndTasks) {
  std::atomic<int> sum{0};
  const auto addUp = [&] {
    parallelFor({0, 20}, [&](const cv::Range& outer) {
      for (int i = outer.start; i < outer.end; ++i)
        parallelFor({0, i}, [&](const cv::Range& inner) { sum += inner.size(); });
    });
  };
  runTogether(addUp, addUp);
  EXPECT_EQ(sum, 2 * 190);
}

TEST_P(TasksOn, HereIsTheCallingThread) {
  const auto caller = std::this_thread::get_id();
  std::atomic<bool> beside_has_run{false};
  runTogether([&] { EXPECT_EQ(std::this_thread::get_id(), caller); },
              [&] { beside_has_run = true; });
  EXPECT_TRUE(beside_has_run);
}

TEST_P(TasksOn, TasksPassExceptionsOnAfterBothHaveEnded) {
  for (const auto& [here_fails, beside_fails] :
       {std::pair(true, false), {false, true}, {true, true}}) {
    std::atomic<int> ended{0};
    const auto task = [&](const char* name, bool fails) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      ++ended;
      if (fails) throw std::runtime_error(name);
    };
    try {
      runTogether([&, fails = here_fails] { task("here", fails); },
                  [&, fails = beside_fails] { task("beside", fails); });
      FAIL() << "nothing was thrown";
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(error.what(), std::string(here_fails ? "here" : "beside"));
    }
    EXPECT_EQ(ended, 2);
  }
}

INSTANTIATE_TEST_SUITE_P(Threads, TasksOn, testing::Values(1, 2, 3, 7));

TEST(Tasks, RunAtTheSameTime) {
  if (cv::getNumThreads() < 2) GTEST_SKIP() << "one core";
  std::promise<void> from_here, from_beside;
  const auto meet = [](std::promise<void>& mine, std::promise<void>& others) {
    mine.set_value();
    EXPECT_EQ(others.get_future().wait_for(std::chrono::seconds(60)), std::future_status::ready);
  };
  runTogether([&] { meet(from_here, from_beside); }, [&] { meet(from_beside, from_here); });
}

// `here` may wait for another process: what it does not need is done meanwhile.
TEST(Tasks, OnOneThreadTheOneThatMayWaitIsTheLast) {
  const int threads_before = cv::getNumThreads();
  cv::setNumThreads(1);
  std::string order;
  runTogether([&] { order += "here"; }, [&] { order += "beside "; });
  cv::setNumThreads(threads_before);
  EXPECT_EQ(order, "beside here");
}

// Like the nodelets of a manager.
TEST(Tasks, MayBeUsedByManyThreads) {
  std::atomic<int> sum{0};
  std::vector<std::thread> callers;
  for (int i = 0; i < 6; ++i)
    callers.emplace_back([&] {
      const auto caller = std::this_thread::get_id();
      for (int repetition = 0; repetition < 200; ++repetition) {
        const auto loop = [&] {
          parallelFor({0, 10}, [&](const cv::Range& part) { sum += part.size(); });
        };
        const auto here = [&] {
          EXPECT_EQ(std::this_thread::get_id(), caller);
          loop();
        };
        runTogether(here, loop);
      }
    });
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(sum, 6 * 200 * 2 * 10);
}

}  // namespace
}  // namespace predictive_stereo
