#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

namespace predictive_stereo {

/// A thread that processes the newest job. A job that is still waiting when the next one arrives is
/// dropped: so latency stays bounded if frames arrive faster than they can be processed.
template <class Job>
class LatestWorker {
 public:
  /// @param work  must not throw.
  explicit LatestWorker(std::function<void(Job&)> work)
      : work_(std::move(work)), thread_([this] { run(); }) {}

  ~LatestWorker() { stop(); }
  LatestWorker(const LatestWorker&) = delete;
  LatestWorker& operator=(const LatestWorker&) = delete;

  void push(Job job) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (waiting_) ++dropped_;
      waiting_ = std::move(job);
    }
    changed_.notify_one();
  }

  uint64_t dropped() const { return dropped_; }

  /// Waits for the current job and ends the thread.
  void stop() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stop_ = true;
    }
    changed_.notify_one();
    if (thread_.joinable()) thread_.join();
  }

 private:
  void run() {
    while (true) {
      std::optional<Job> job;
      {
        std::unique_lock<std::mutex> lock(mutex_);
        changed_.wait(lock, [this] { return stop_ || waiting_; });
        if (stop_) return;
        std::swap(job, waiting_);
      }
      work_(*job);
    }
  }

  std::function<void(Job&)> work_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Job> waiting_;
  bool stop_ = false;
  std::atomic<uint64_t> dropped_{0};
  std::thread thread_;  // last: uses the members above
};

}  // namespace predictive_stereo
