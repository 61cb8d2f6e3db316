#include "matching/aligned_buffer.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <string>
#include <utility>

namespace predictive_stereo {
namespace {

bool isAligned(const uint8_t* memory, size_t alignment) {
  return reinterpret_cast<uintptr_t>(memory) % alignment == 0;
}

// Of this process [kB].
size_t virtualMemory() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;)
    if (word == "VmSize:") {
      size_t kilobytes = 0;
      status >> kilobytes;
      return kilobytes;
    }
  return 0;
}

TEST(AlignedBuffer, GrowsAndNeverShrinks) {
  AlignedBuffer buffer;
  EXPECT_EQ(buffer.data(), nullptr);
  for (const size_t bytes : {size_t{1}, size_t{1} << 16, size_t{5} << 20, size_t{9} << 20}) {
    uint8_t* const memory = buffer.reserve(bytes);
    EXPECT_EQ(memory, buffer.data());
    EXPECT_TRUE(isAligned(memory, 64)) << bytes;
    std::memset(memory, 7, bytes);  // all of it is there
    EXPECT_EQ(memory[bytes - 1], 7);
  }
  EXPECT_TRUE(isAligned(buffer.data(), size_t{2} << 20)) << "a huge page";
  uint8_t* const memory = buffer.data();
  EXPECT_EQ(buffer.reserve(100), memory);
}

TEST(AlignedBuffer, GivesAllBack) {
  constexpr size_t kBytes = size_t{64} << 20;
  { AlignedBuffer().reserve(kBytes); }
  const size_t before = virtualMemory();
  for (int i = 0; i < 20; ++i) {
    AlignedBuffer buffer;
    buffer.reserve(kBytes + i);
    const AlignedBuffer moved = std::move(buffer);
    EXPECT_TRUE(moved.data());
  }
  EXPECT_LT(virtualMemory(), before + 2 * kBytes / 1024);
}

}  // namespace
}  // namespace predictive_stereo
