/// Parallel loops and tasks of the package. They run on TBB; all of a process share
/// cv::getNumThreads() threads.
#pragma once

#include <functional>
#include <memory>
#include <opencv2/core/types.hpp>

namespace predictive_stereo {

/// Calls body(part) for parts of `range`, in parallel, and returns when all have returned. Unlike
/// cv::parallel_for_, it is also parallel while another loop runs. A thread that waits for the end
/// of its loop takes no other work meanwhile, so no long task delays that end.
/// @param most_parts  upper bound of the number of parts; 0: one for each index.
/// @throws what a body threw.
void parallelFor(const cv::Range& range, const std::function<void(const cv::Range&)>& body,
                 int most_parts = 0);

/// Calls body(i) for each i in [0, count) in this way.
template <class Body>
void parallelForEach(int count, const Body& body) {
  parallelFor({0, count}, [&](const cv::Range& part) {
    for (int i = part.start; i < part.end; ++i) body(i);
  });
}

/// Calls both, and returns when both have returned. `here` runs in the calling thread and may wait;
/// `beside` runs in another thread at the same time, or after `here`; on one thread, before it.
/// @throws what `here` threw, or else what `beside` threw, after both have ended.
void runTogether(const std::function<void()>& here, const std::function<void()>& beside);

/// What executes them. Tests and benchmarks may replace it.
class TaskRunner {
 public:
  virtual ~TaskRunner() = default;
  /// Calls body(begin, end) for parts that together are [0, count), count > 1.
  virtual void loop(int count, const std::function<void(int, int)>& body) = 0;
  virtual void together(const std::function<void()>& here, const std::function<void()>& beside) = 0;
};

/// @param runner  nullptr: TBB. Nothing may run meanwhile.
void replaceTaskRunner(std::unique_ptr<TaskRunner> runner);

}  // namespace predictive_stereo
