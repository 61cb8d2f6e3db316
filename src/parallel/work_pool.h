#pragma once

#include <deque>
#include <mutex>
#include <vector>

namespace predictive_stereo {

/// Buffers for threads of a parallel loop, one for each thread; kept between loops.
template <class Work>
class WorkPool {
 public:
  /// Calls body(work), from any thread. Results must not depend on the previous contents of `work`.
  /// If body throws, the work is kept, too.
  template <class Body>
  void withWork(const Body& body) {
    Taken taken{*this, take()};
    body(taken.work);
  }

 private:
  struct Taken {
    WorkPool& pool;
    Work& work;
    ~Taken() { pool.giveBack(work); }
  };

  Work& take() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (free_.empty()) {
      free_.reserve(works_.size() + 1);
      return works_.emplace_back();
    }
    Work* const work = free_.back();
    free_.pop_back();
    return *work;
  }
  void giveBack(Work& work) {
    const std::lock_guard<std::mutex> lock(mutex_);
    free_.push_back(&work);  // has room
  }

  std::mutex mutex_;
  std::deque<Work> works_;  // its elements stay where they are
  std::vector<Work*> free_;
};

}  // namespace predictive_stereo
