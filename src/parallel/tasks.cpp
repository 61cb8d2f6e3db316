#include "parallel/tasks.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <exception>
#include <map>
#include <mutex>
#include <opencv2/core/utility.hpp>

namespace predictive_stereo {
namespace {

/// The threads that may work on a loop. Kept for each number of threads, because others may still
/// work in the arena of the number before.
tbb::task_arena& arenaOf(int threads) {
  static std::mutex mutex;
  static std::map<int, tbb::task_arena> arenas;
  const std::lock_guard<std::mutex> lock(mutex);
  return arenas.try_emplace(threads, threads).first->second;
}

std::exception_ptr thrownBy(const std::function<void()>& task) {
  try {
    task();
  } catch (...) {
    return std::current_exception();
  }
  return nullptr;
}

class TbbRunner : public TaskRunner {
 public:
  void loop(int count, const std::function<void(int, int)>& body) override {
    const int threads = cv::getNumThreads();
    if (threads <= 1) return body(0, count);
    const auto share = [&] {
      tbb::parallel_for(tbb::blocked_range<int>(0, count),
                        [&](const auto& part) { body(part.begin(), part.end()); });
    };
    arenaOf(threads).execute([&] { tbb::this_task_arena::isolate(share); });
  }

  void together(const std::function<void()>& here, const std::function<void()>& beside) override {
    const int threads = cv::getNumThreads();
    std::exception_ptr thrown_here, thrown_beside;
    const auto doHere = [&] { thrown_here = thrownBy(here); };
    const auto doBeside = [&] { thrown_beside = thrownBy(beside); };
    if (threads <= 1) {
      // `here` may wait for what others do: the later it begins, the more of that is done.
      doBeside();
      doHere();
    } else {
      tbb::task_group group;
      arenaOf(threads).execute([&] { group.run(doBeside); });
      doHere();  // outside of the arena: TBB may let another thread execute what is inside
      arenaOf(threads).execute([&] { group.wait(); });
    }
    if (thrown_here) std::rethrow_exception(thrown_here);
    if (thrown_beside) std::rethrow_exception(thrown_beside);
  }
};

std::unique_ptr<TaskRunner>& runner() {
  static std::unique_ptr<TaskRunner> runner = std::make_unique<TbbRunner>();
  return runner;
}

}  // namespace

void parallelFor(const cv::Range& range, const std::function<void(const cv::Range&)>& body,
                 int most_parts) {
  const int size = range.size();
  if (size <= 0) return;
  const int parts = most_parts > 0 ? std::min(most_parts, size) : size;
  if (parts == 1) return body(range);
  const auto beginOf = [&](int part) {
    return range.start + static_cast<int>(int64_t{size} * part / parts);
  };
  runner()->loop(parts, [&](int begin, int end) { body({beginOf(begin), beginOf(end)}); });
}

void runTogether(const std::function<void()>& here, const std::function<void()>& beside) {
  runner()->together(here, beside);
}

void replaceTaskRunner(std::unique_ptr<TaskRunner> replacement) {
  runner() = replacement ? std::move(replacement) : std::make_unique<TbbRunner>();
}

}  // namespace predictive_stereo
