#pragma once

#include <mutex>
#include <opencv2/core/utility.hpp>

namespace predictive_stereo {

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
