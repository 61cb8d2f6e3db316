#pragma once

#include <deque>
#include <mutex>
#include <opencv2/core/utility.hpp>
#include <vector>

namespace predictive_stereo {

/// Memory of threads that share work, one each; kept from use to use.
template <class Work>
class WorkPool {
 public:
  /// Calls body(i, work) for i in [0, count), in parallel. Results must not depend on what is left
  /// in `work`.
  template <class Body>
  void forEach(int count, const Body& body) {
    // Pieces differ much in size; most are so small that a task each would cost more than they do.
    const double tasks = 8.0 * cv::getNumThreads();
    const auto share = [&](const cv::Range& mine) {
      use([&](Work& work) {
        for (int i = mine.start; i < mine.end; ++i) body(i, work);
      });
    };
    cv::parallel_for_(cv::Range(0, count), share, tasks);
  }

  /// Calls body(work), from any thread.
  template <class Body>
  void use(const Body& body) {
    Work& work = take();
    body(work);
    giveBack(work);
  }

 private:
  Work& take() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (free_.empty()) return works_.emplace_back();
    Work* const work = free_.back();
    free_.pop_back();
    return *work;
  }
  void giveBack(Work& work) {
    const std::lock_guard<std::mutex> lock(mutex_);
    free_.push_back(&work);
  }

  std::mutex mutex_;
  std::deque<Work> works_;  // its elements stay where they are
  std::vector<Work*> free_;
};

}  // namespace predictive_stereo
