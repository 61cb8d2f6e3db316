/// Memory for large volumes: aligned for SIMD, and in huge pages if the system has them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>

// AddressSanitizer sees reads beyond what malloc gives, not beyond what the system gives.
#if defined(__linux__) && !defined(__SANITIZE_ADDRESS__)
#include <sys/mman.h>
#define PREDICTIVE_STEREO_MAPS_MEMORY
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
    memory_ = alignment == kHugePage ? inHugePages(rounded) : onHeap(alignment, rounded);
    if (!memory_) throw std::bad_alloc();
    capacity_ = rounded;
    return data();
  }
  uint8_t* data() const { return memory_.get(); }

 private:
  static constexpr size_t kCacheLine = 64;
  static constexpr size_t kHugePage = size_t{2} << 20;

  struct Free {
    size_t mapped_bytes;  ///< 0, as std::unique_ptr sets it: of the heap
    void operator()(uint8_t* memory) const {
#ifdef PREDICTIVE_STEREO_MAPS_MEMORY
      if (mapped_bytes > 0) return void(munmap(memory, mapped_bytes));
#endif
      std::free(memory);
    }
  };
  using Memory = std::unique_ptr<uint8_t[], Free>;

  static Memory onHeap(size_t alignment, size_t bytes) {
    return Memory(static_cast<uint8_t*>(std::aligned_alloc(alignment, bytes)));
  }
  /// From the system, as memory of the heap may have been used before: it stays in small pages.
  static Memory inHugePages(size_t bytes) {
#ifdef PREDICTIVE_STEREO_MAPS_MEMORY
    void* const mapped = mmap(nullptr, bytes + kHugePage, PROT_READ | PROT_WRITE,
                              MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (mapped == MAP_FAILED) return nullptr;
    // What is before the first multiple of a huge page and behind the memory goes back.
    auto* const begin = static_cast<uint8_t*>(mapped);
    const size_t before = (kHugePage - reinterpret_cast<uintptr_t>(begin) % kHugePage) % kHugePage;
    if (before > 0) munmap(begin, before);
    if (before < kHugePage) munmap(begin + before + bytes, kHugePage - before);
    madvise(begin + before, bytes, MADV_HUGEPAGE);
    return Memory(begin + before, Free{bytes});
#else
    return onHeap(kHugePage, bytes);
#endif
  }

  Memory memory_;
  size_t capacity_ = 0;
};

}  // namespace predictive_stereo

#undef PREDICTIVE_STEREO_MAPS_MEMORY
