#pragma once

#include <ros/init.h>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>

namespace predictive_stereo {

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

}  // namespace predictive_stereo
