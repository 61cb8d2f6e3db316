#pragma once

#include <condition_variable>
#include <functional>
#include <future>
#include <mutex>
#include <thread>

namespace predictive_stereo {

/// A thread for work beside the caller's. It stays, as a thread for each task (std::async) leaks:
/// OpenCV keeps some memory of every thread that has run its loops.
class SecondThread {
 public:
  /// A task at work. Waits for its end when it goes out of scope.
  class Running {
   public:
    explicit Running(std::future<void> end) : end_(std::move(end)) {}
    Running(Running&&) = default;
    Running& operator=(Running&&) = delete;
    ~Running() {
      if (end_.valid()) end_.wait();
    }
    /// Waits for the end, once.
    /// @throws what the task threw.
    void get() { end_.get(); }

   private:
    std::future<void> end_;
  };

  SecondThread() = default;
  SecondThread(const SecondThread&) = delete;
  SecondThread& operator=(const SecondThread&) = delete;
  ~SecondThread();

  /// The one before must have ended.
  [[nodiscard]] Running start(std::function<void()> task);

 private:
  void work();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::packaged_task<void()> task_;  // valid: to be done
  bool stopped_ = false;
  std::thread thread_;  // from the first task on
};

}  // namespace predictive_stereo
