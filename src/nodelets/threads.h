/// Threads of a nodelet: that of its frames, how they wait for other nodes, how many loops use.
#pragma once

#include <ros/init.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <opencv2/core/utility.hpp>
#include <optional>
#include <thread>
#include <utility>

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
    struct AtEnd {
      Arrivals& arrivals;
      Clock::time_point begin = Clock::now();
      ~AtEnd() {
        if (!arrivals.waiting_.exchange(false)) return;
        const std::chrono::duration<double> waited = Clock::now() - begin;
        arrivals.waited_s_ = arrivals.waited_s_ + waited.count();
      }
    } at_end{*this};
    std::unique_lock<std::mutex> lock(mutex_);
    while (true) {
      const uint64_t known = count_;
      lock.unlock();
      auto answer = ask();
      if (answer || !ros::ok()) return answer;
      lock.lock();
      if (stopped_ || Clock::now() >= deadline) return answer;
      const auto has_news = [&] { return stopped_ || count_ != known; };
      waiting_ = true;
      if (!changed_.wait_until(lock, deadline, has_news) || stopped_) return answer;
    }
  }

  /// Whether the nodelet's thread waits now, and how long it has waited until now.
  bool isWaiting() const { return waiting_; }
  double waited_s() const { return waited_s_; }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  uint64_t count_ = 0;
  bool stopped_ = false;
  std::atomic<bool> waiting_{false};
  std::atomic<double> waited_s_{0};
};

/// A thread that processes jobs in their order. One job may wait, and those that arrive while the
/// work waits for other nodes, unless the work alone takes longer than jobs need to arrive. If more
/// arrive, it is too slow: then only the newest one stays, so that latency is bounded.
template <class Job>
class FrameWorker {
 public:
  /// @param work  must not throw. @param arrivals  that it waits for.
  FrameWorker(std::function<void(Job&)> work, const Arrivals& arrivals)
      : work_(std::move(work)), arrivals_(arrivals), thread_([this] { run(); }) {}

  ~FrameWorker() { stop(); }
  FrameWorker(const FrameWorker&) = delete;
  FrameWorker& operator=(const FrameWorker&) = delete;

  void push(Job job) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      jobs_.push_back(std::move(job));
      const auto now = Clock::now();
      if (last_push_) smooth(seconds(now - *last_push_), period_s_);
      last_push_ = now;
      if (jobs_.size() > (isTooSlow() ? 1 : arrivals_.isWaiting() ? kMost : most_)) {
        dropped_ += jobs_.size() - 1;
        jobs_.erase(jobs_.begin(), jobs_.end() - 1);
        most_ = 1;
      }
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
  using Clock = std::chrono::steady_clock;
  static constexpr size_t kMost = 100;

  static double seconds(Clock::duration time) {
    return std::chrono::duration<double>(time).count();
  }
  static void smooth(double value, double& mean) {
    constexpr double kShare = 0.2;
    mean = mean > 0 ? mean + kShare * (value - mean) : value;
  }
  bool isTooSlow() const { return work_s_ > period_s_; }

  void run() {
    std::unique_lock<std::mutex> lock(mutex_);
    while (true) {
      changed_.wait(lock, [this] { return stop_ || !jobs_.empty(); });
      if (stop_) return;
      Job job = std::move(jobs_.front());
      jobs_.pop_front();
      lock.unlock();
      const auto begin = Clock::now();
      const double before_s = arrivals_.waited_s();
      work_(job);
      lock.lock();
      const double waited_s = arrivals_.waited_s() - before_s;
      smooth(seconds(Clock::now() - begin) - waited_s, work_s_);
      // Those that came while it waited, one during the next work, and one that comes early.
      most_ = waited_s > 0 ? jobs_.size() + 2 : std::max<size_t>(most_ - 1, 1);
    }
  }

  std::function<void(Job&)> work_;
  const Arrivals& arrivals_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Job> jobs_;
  size_t most_ = 1;                   // jobs that may wait
  double work_s_ = 0, period_s_ = 0;  // means of the last ones; work without waits
  std::optional<Clock::time_point> last_push_;
  bool stop_ = false;
  std::atomic<uint64_t> dropped_{0};
  std::thread thread_;  // last: uses the members above
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
