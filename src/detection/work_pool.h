#pragma once

#include <algorithm>
#include <atomic>
#include <opencv2/core/utility.hpp>
#include <vector>

namespace predictive_stereo {

/// Memory of threads that share work, one each; kept from use to use.
template <class Work>
class WorkPool {
 public:
  /// Calls body(i, work) for i in [0, count), in parallel; each thread takes the next one as soon
  /// as it can. Results must not depend on what is left in `work`.
  template <class Body>
  void forEach(int count, const Body& body) {
    const int threads = std::clamp(cv::getNumThreads(), 1, std::max(count, 1));
    if (static_cast<int>(works_.size()) < threads) works_.resize(static_cast<size_t>(threads));
    if (threads == 1 || count == 1) {
      for (int i = 0; i < count; ++i) body(i, works_[0]);
      return;
    }
    std::atomic<int> next{0};
    cv::parallel_for_(cv::Range(0, threads), [&](const cv::Range& mine) {
      for (int t = mine.start; t < mine.end; ++t)
        for (int i = next++; i < count; i = next++) body(i, works_[static_cast<size_t>(t)]);
    });
  }

 private:
  std::vector<Work> works_;
};

/// The same for work that needs no memory: calls body(i).
template <class Body>
void forEachInParallel(int count, const Body& body) {
  struct Nothing {};
  WorkPool<Nothing>().forEach(count, [&](int i, Nothing&) { body(i); });
}

}  // namespace predictive_stereo
