/// Every piece of work is done once, with memory that no other thread uses, for any number of
/// threads.
#include "parallel/work_pool.h"

#include <gtest/gtest.h>

#include <atomic>
#include <mutex>
#include <numeric>
#include <opencv2/core/utility.hpp>
#include <set>
#include <stdexcept>
#include <vector>

#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

// Calls body(i, work) for i in [0, count), in parallel.
template <class Work, class Body>
void forEach(WorkPool<Work>& pool, int count, const Body& body) {
  parallelForEach(count, [&](int i) { pool.withWork([&](Work& work) { body(i, work); }); });
}

class WorkPoolOn : public testing::TestWithParam<int> {
 protected:
  void SetUp() override { cv::setNumThreads(GetParam()); }
  void TearDown() override { cv::setNumThreads(threads_before_); }

 private:
  int threads_before_ = cv::getNumThreads();
};

struct Memory {
  std::atomic<bool> in_use{false};
  std::vector<int> done;
};

TEST_P(WorkPoolOn, DoesEachPieceOnce) {
  WorkPool<Memory> pool;
  for (int count : {0, 1, 2, 3, 5, 100, 4, 257}) {
    std::vector<std::atomic<int>> times(static_cast<size_t>(count));
    std::atomic<int> shared_memory{0};
    forEach(pool, count, [&](int i, Memory& memory) {
      if (memory.in_use.exchange(true)) ++shared_memory;
      ++times[static_cast<size_t>(i)];
      memory.done.push_back(i);
      memory.in_use = false;
    });
    EXPECT_EQ(shared_memory, 0);
    for (const auto& t : times) EXPECT_EQ(t, 1);
  }
}

TEST_P(WorkPoolOn, KeepsMemoryFromUseToUse) {
  WorkPool<Memory> pool;
  std::set<const Memory*> memories;
  std::mutex mutex;
  for (int round = 0; round < 20; ++round)
    forEach(pool, 12, [&](int i, Memory& memory) {
      memory.done.push_back(i);
      const std::lock_guard<std::mutex> lock(mutex);
      memories.insert(&memory);
    });
  EXPECT_LE(memories.size(), static_cast<size_t>(std::max(cv::getNumThreads(), 1)));
  size_t done = 0;
  for (const Memory* memory : memories) done += memory->done.size();
  EXPECT_EQ(done, 20u * 12u);
}

TEST_P(WorkPoolOn, KeepsMemoryIfAPieceThrows) {
  WorkPool<Memory> pool;
  std::set<const Memory*> memories;
  std::mutex mutex;
  for (int round = 0; round < 20; ++round)
    EXPECT_THROW(forEach(pool, 12,
                         [&](int i, Memory& memory) {
                           const std::lock_guard<std::mutex> lock(mutex);
                           memories.insert(&memory);
                           if (i % 4 == 0) throw std::runtime_error("a piece");
                         }),
                 std::runtime_error);
  EXPECT_LE(memories.size(), static_cast<size_t>(std::max(cv::getNumThreads(), 1)));
}

TEST_P(WorkPoolOn, GivesTheSameForAnyNumberOfThreads) {
  WorkPool<std::vector<int>> pool;
  std::vector<int> sums(50);
  forEach(pool, 50, [&](int i, std::vector<int>& numbers) {
    numbers.assign(static_cast<size_t>(i), 3);
    sums[static_cast<size_t>(i)] = std::accumulate(numbers.begin(), numbers.end(), 0);
  });
  for (int i = 0; i < 50; ++i) EXPECT_EQ(sums[static_cast<size_t>(i)], 3 * i);
}

TEST_P(WorkPoolOn, WorksInsideAParallelLoop) {
  std::vector<int> sums(6);
  parallelFor({0, 6}, [&](const cv::Range& range) {
    for (int k = range.start; k < range.end; ++k) {
      WorkPool<int> pool;
      std::atomic<int> sum{0};
      forEach(pool, k + 1, [&](int i, int&) { sum += i; });
      sums[static_cast<size_t>(k)] = sum;
    }
  });
  EXPECT_EQ(sums, (std::vector<int>{0, 1, 3, 6, 10, 15}));
}

INSTANTIATE_TEST_SUITE_P(Threads, WorkPoolOn, testing::Values(1, 2, 3, 7));

}  // namespace
}  // namespace predictive_stereo
