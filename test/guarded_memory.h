/// Memory beside an inaccessible page (guard page): accesses beyond an image's last pixel, or
/// before its first one, crash in every build.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <memory>
#include <new>
#include <opencv2/core.hpp>

#include "every_target.h"

namespace predictive_stereo::testing {

/// Position of the guard page.
enum class Guard { kBehind, kBefore };

class GuardedMemory {
 public:
  GuardedMemory(size_t bytes, Guard guard) {
    const auto page = static_cast<size_t>(sysconf(_SC_PAGESIZE));
    const size_t room = (bytes + page - 1) / page * page;
    mapped_ = room + page;
    void* const mapping =
        mmap(nullptr, mapped_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (mapping == MAP_FAILED) throw std::bad_alloc();
    mapping_ = static_cast<unsigned char*>(mapping);
    unsigned char* const forbidden = guard == Guard::kBehind ? mapping_ + room : mapping_;
    data_ = guard == Guard::kBehind ? forbidden - bytes : mapping_ + page;
    if (mprotect(forbidden, page, PROT_NONE) != 0) throw std::bad_alloc();
  }
  GuardedMemory(const GuardedMemory&) = delete;
  GuardedMemory& operator=(const GuardedMemory&) = delete;
  ~GuardedMemory() { munmap(mapping_, mapped_); }

  unsigned char* data() const { return data_; }

 private:
  unsigned char *mapping_, *data_;
  size_t mapped_;
};

/// Rows of any length up to `most` beside a guard page, filled with noise.
template <class T>
class GuardedRow {
 public:
  GuardedRow(int most, Guard guard, double low = 0, double high = 0)
      : most_(most), guard_(guard), memory_(static_cast<size_t>(most) * sizeof(T), guard) {
    cv::Mat all(1, most, cv::DataType<T>::type, memory_.data());
    cv::theRNG().fill(all, cv::RNG::UNIFORM, low, high);
  }
  T* operator()(int length) const {
    T* const all = reinterpret_cast<T*>(memory_.data());
    return guard_ == Guard::kBehind ? all + (most_ - length) : all;
  }

 private:
  int most_;
  Guard guard_;
  GuardedMemory memory_;
};

/// During the lifetime of this object every new cv::Mat is beside a guard page: those of the test
/// and those of the code under test.
class GuardEveryMat {
 public:
  explicit GuardEveryMat(Guard guard) : before_(cv::Mat::getDefaultAllocator()) {
    // Never destroyed, because images may live longer than any owner.
    static auto* const behind = new Allocator(Guard::kBehind);
    static auto* const before = new Allocator(Guard::kBefore);
    cv::Mat::setDefaultAllocator(guard == Guard::kBehind ? behind : before);
  }
  GuardEveryMat(const GuardEveryMat&) = delete;
  GuardEveryMat& operator=(const GuardEveryMat&) = delete;
  ~GuardEveryMat() { cv::Mat::setDefaultAllocator(before_); }

 private:
  class Allocator : public cv::MatAllocator {
   public:
    explicit Allocator(Guard guard) : guard_(guard) {}

    cv::UMatData* allocate(int dims, const int* sizes, int type, void* data, size_t* step,
                           cv::AccessFlag, cv::UMatUsageFlags) const override {
      CV_Assert(!data);
      size_t bytes = CV_ELEM_SIZE(type);
      for (int i = dims - 1; i >= 0; --i) {
        if (step) step[i] = bytes;
        bytes *= static_cast<size_t>(sizes[i]);
      }
      auto memory = std::make_unique<GuardedMemory>(bytes, guard_);
      auto* const u = new cv::UMatData(this);
      u->data = u->origdata = memory->data();
      u->size = bytes;
      u->handle = memory.release();
      return u;
    }
    bool allocate(cv::UMatData* u, cv::AccessFlag, cv::UMatUsageFlags) const override { return u; }
    void deallocate(cv::UMatData* u) const override {
      if (!u) return;
      delete static_cast<GuardedMemory*>(u->handle);
      delete u;
    }

   private:
    Guard guard_;
  };

  cv::MatAllocator* before_;
};

/// Largest length of rows. Rows up to this length end at all positions of vectors and of the blocks
/// that loops process.
constexpr int kMostGuarded = 140;

/// Calls body(guard) for both positions, on every SIMD target; see forEveryTarget.
template <class Body>
void forEveryGuardAndTarget(const Body& body) {
  forEveryTarget([&] {
    for (const Guard guard : {Guard::kBehind, Guard::kBefore}) body(guard);
  });
}

}  // namespace predictive_stereo::testing
