#include "nodelets/thread_limit.h"

#include <mutex>
#include <opencv2/core/utility.hpp>

namespace predictive_stereo {

void limitThreads(int threads) {
  static std::mutex mutex;
  static int limit = 0;  // no limit
  const std::lock_guard<std::mutex> lock(mutex);
  if (threads <= 0 || (limit > 0 && threads >= limit)) return;
  limit = threads;
  cv::setNumThreads(threads);
}

}  // namespace predictive_stereo
