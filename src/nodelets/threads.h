/// Threads of a nodelet: that of its frames, how they wait for other nodes, how many loops use.
#pragma once

#include <ros/init.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <opencv2/core/utility.hpp>
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

/// Wakes the thread of a nodelet that waits for messages of other nodes. Thread-safe.
class Arrivals {
 public:
  /// Something has arrived: who waits asks again.
  void notify() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      ++count_;
    }
    changed_.notify_all();
  }

  /// Ends all waits, also later ones: the nodelet is unloaded.
  void stop() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stopped_ = true;
    }
    changed_.notify_all();
  }

  /// Calls `ask` now, and again after each arrival, until its result is true or timeout_s has
  /// passed; returns the last result. (tf2's own wait polls every 10 ms, which is too slow for a
  /// frame.)
  template <class Ask>
  auto waitFor(double timeout_s, Ask&& ask) {
    using Clock = std::chrono::steady_clock;
    const auto deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                             std::chrono::duration<double>(timeout_s));
    std::unique_lock<std::mutex> lock(mutex_);
    while (true) {
      const uint64_t known = count_;
      lock.unlock();
      auto answer = ask();
      if (answer || !ros::ok()) return answer;
      lock.lock();
      const auto has_news = [&] { return stopped_ || count_ != known; };
      if (!changed_.wait_until(lock, deadline, has_news) || stopped_ || Clock::now() >= deadline)
        return answer;
    }
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  uint64_t count_ = 0;
  bool stopped_ = false;
};

/// Limits the threads of parallel loops in this process. All nodelets of a manager share them. The
/// smallest of several limits is used, until the process ends.
/// @param threads  0: no limit.
inline void limitThreads(int threads) {
  static std::mutex mutex;
  static int limit = 0;  // no limit
  const std::lock_guard<std::mutex> lock(mutex);
  if (threads <= 0 || (limit > 0 && threads >= limit)) return;
  limit = threads;
  cv::setNumThreads(threads);
}

}  // namespace predictive_stereo
