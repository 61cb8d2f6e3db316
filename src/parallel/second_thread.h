#pragma once

#include <condition_variable>
#include <functional>
#include <future>
#include <mutex>
#include <thread>

namespace predictive_stereo {

/// A thread that runs tasks at the same time as the caller. It is kept between tasks: a new thread
/// for each task (std::async) would leak, as OpenCV keeps memory of every thread that ran its
/// loops.
class SecondThread {
 public:
  /// A running task. The destructor waits for its end.
  class Running {
   public:
    explicit Running(std::future<void> end) : end_(std::move(end)) {}
    Running(Running&&) = default;
    Running& operator=(Running&&) = delete;
    ~Running() {
      if (end_.valid()) end_.wait();
    }
    /// Waits for the end. Must be called at most once.
    /// @throws what the task threw.
    void get() { end_.get(); }

   private:
    std::future<void> end_;
  };

  SecondThread() = default;
  SecondThread(const SecondThread&) = delete;
  SecondThread& operator=(const SecondThread&) = delete;
  ~SecondThread();

  /// The previous task must have ended.
  [[nodiscard]] Running start(std::function<void()> task);

 private:
  void runTasks();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::packaged_task<void()> task_;  // valid until the thread takes it
  bool stopped_ = false;
  std::thread thread_;  // started with the first task
};

}  // namespace predictive_stereo
