/// Memory for large volumes: aligned for SIMD, and in huge pages if the system has them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace predictive_stereo {

class AlignedBuffer {
 public:
  /// Returns at least `bytes` bytes, with undefined contents. Allocates only if the buffer grows.
  uint8_t* reserve(size_t bytes) {
    if (bytes <= capacity_) return data();
    memory_.reset();
    capacity_ = 0;
    const size_t alignment = bytes < kHugePage ? kCacheLine : kHugePage;
    const size_t rounded = (bytes + alignment - 1) / alignment * alignment;
    memory_.reset(static_cast<uint8_t*>(std::aligned_alloc(alignment, rounded)));
    if (!memory_) throw std::bad_alloc();
#ifdef __linux__
    if (alignment == kHugePage) madvise(memory_.get(), rounded, MADV_HUGEPAGE);
#endif
    capacity_ = rounded;
    return data();
  }
  uint8_t* data() const { return memory_.get(); }

 private:
  static constexpr size_t kCacheLine = 64;
  static constexpr size_t kHugePage = size_t{2} << 20;
  struct Free {
    void operator()(uint8_t* memory) const { std::free(memory); }
  };

  std::unique_ptr<uint8_t[], Free> memory_;
  size_t capacity_ = 0;
};

}  // namespace predictive_stereo
