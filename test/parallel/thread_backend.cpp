/// Runs OpenCV's parallel loops by std::threads: for builds with the thread sanitizer, which does
/// not see how Debian's OpenCV and TBB hand over work. Linked into each test of such a build.
#include <algorithm>
#include <atomic>
#include <memory>
#include <opencv2/core/parallel/parallel_backend.hpp>
#include <opencv2/core/utility.hpp>
#include <thread>
#include <vector>

namespace predictive_stereo {
namespace {

class ThreadBackend : public cv::parallel::ParallelForAPI {
 public:
  /// OpenCV calls it from one thread at a time: a loop beside another one is run serially.
  void parallel_for(int tasks, FN_parallel_for_body_cb_t body, void* data) override {
    std::atomic<int> next{0};
    const auto work = [&](int thread) {
      thread_num_ = thread;
      for (int i; (i = next++) < tasks;) body(i, i + 1, data);
    };
    std::vector<std::thread> others;
    for (int i = 1; i < std::min(tasks, threads_.load()); ++i) others.emplace_back(work, i);
    work(0);
    for (std::thread& other : others) other.join();
  }

  int getThreadNum() const override { return thread_num_; }
  int getNumThreads() const override { return threads_; }
  /// @param threads  at most that many; negative: as at the start.
  int setNumThreads(int threads) override {
    return threads_.exchange(threads < 0 ? kThreads : std::max(threads, 1));
  }
  const char* getName() const override { return "std::thread"; }

 private:
  static constexpr int kThreads = 3;
  static thread_local int thread_num_;
  std::atomic<int> threads_{kThreads};
};
thread_local int ThreadBackend::thread_num_ = 0;

[[maybe_unused]] const bool is_used = [] {
  cv::parallel::setParallelForBackend(std::make_shared<ThreadBackend>(), false);
  return true;
}();

}  // namespace
}  // namespace predictive_stereo
