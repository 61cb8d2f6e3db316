/// Tasks run beside the caller, all on one thread, and end before the objects that they use.
#include "parallel/second_thread.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <set>
#include <stdexcept>

namespace predictive_stereo {
namespace {

TEST(SecondThread, IsOneForAllTasks) {
  SecondThread thread;
  std::set<std::thread::id> ids;
  for (int i = 0; i < 100; ++i) thread.start([&] { ids.insert(std::this_thread::get_id()); }).get();
  EXPECT_EQ(ids.size(), 1U);
  EXPECT_EQ(ids.count(std::this_thread::get_id()), 0U);
}

TEST(SecondThread, RunsBesideTheCaller) {
  SecondThread thread;
  std::promise<void> by_caller;
  SecondThread::Running task = thread.start([&] { by_caller.get_future().wait(); });
  by_caller.set_value();  // after starting the task: in one thread both would wait forever
  task.get();
}

TEST(SecondThread, PassesExceptionsOnAndGoesOn) {
  SecondThread thread;
  SecondThread::Running task = thread.start([] { throw std::runtime_error("broken"); });
  EXPECT_THROW(task.get(), std::runtime_error);
  bool done = false;
  thread.start([&] { done = true; }).get();
  EXPECT_TRUE(done);
}

TEST(SecondThread, ATaskThatNobodyAsksForIsWaitedFor) {
  SecondThread thread;
  std::atomic<bool> done{false};
  {
    const SecondThread::Running task = thread.start([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      done = true;
    });
  }
  EXPECT_TRUE(done);
}

TEST(SecondThread, NeedsNoTask) { const SecondThread thread; }

}  // namespace
}  // namespace predictive_stereo
