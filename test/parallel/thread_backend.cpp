/// Runs parallel loops and tasks, ours and OpenCV's, by std::threads: for builds with the thread
/// sanitizer, which does not see how TBB hands over work. Linked into each test of such a build,
/// and into the tools that tests run.
#include <algorithm>
#include <atomic>
#include <exception>
#include <memory>
#include <opencv2/core/parallel/parallel_backend.hpp>
#include <opencv2/core/utility.hpp>
#include <thread>
#include <utility>
#include <vector>

#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

thread_local int thread_num = 0;

/// Calls task(i) for i in [0, tasks). @throws one of the exceptions of the tasks.
template <class Task>
void runByThreads(int tasks, int threads, const Task& task) {
  std::atomic<int> next{0};
  std::exception_ptr thrown;
  std::atomic<bool> has_thrown{false};
  const auto work = [&](int thread) {
    const int outer_num = std::exchange(thread_num, thread);
    try {
      for (int i; (i = next++) < tasks;) task(i);
    } catch (...) {
      if (!has_thrown.exchange(true)) thrown = std::current_exception();
    }
    thread_num = outer_num;
  };
  std::vector<std::thread> others;
  for (int i = 1; i < std::min(tasks, threads); ++i) others.emplace_back(work, i);
  work(0);
  for (std::thread& other : others) other.join();
  if (thrown) std::rethrow_exception(thrown);
}

class ThreadBackend : public cv::parallel::ParallelForAPI {
 public:
  /// OpenCV calls it from one thread at a time: a loop beside another one is run serially.
  void parallel_for(int tasks, FN_parallel_for_body_cb_t body, void* data) override {
    runByThreads(tasks, threads_, [&](int i) { body(i, i + 1, data); });
  }
  int getThreadNum() const override { return thread_num; }
  int getNumThreads() const override { return threads_; }
  /// @param threads  at most that many; negative: as at the start.
  int setNumThreads(int threads) override {
    return threads_.exchange(threads < 0 ? kThreads : std::max(threads, 1));
  }
  const char* getName() const override { return "std::thread"; }

 private:
  static constexpr int kThreads = 3;
  std::atomic<int> threads_{kThreads};
};

class ThreadRunner : public TaskRunner {
 public:
  void loop(int count, const std::function<void(int, int)>& body) override {
    runByThreads(count, cv::getNumThreads(), [&](int i) { body(i, i + 1); });
  }
  void together(const std::function<void()>& here, const std::function<void()>& beside) override {
    std::exception_ptr thrown;
    std::thread other([&] {
      try {
        beside();
      } catch (...) {
        thrown = std::current_exception();
      }
    });
    try {
      here();
    } catch (...) {
      other.join();
      throw;
    }
    other.join();
    if (thrown) std::rethrow_exception(thrown);
  }
};

[[maybe_unused]] const bool is_used = [] {
  cv::parallel::setParallelForBackend(std::make_shared<ThreadBackend>(), false);
  replaceTaskRunner(std::make_unique<ThreadRunner>());
  return true;
}();

}  // namespace
}  // namespace predictive_stereo
