/// What fuzz targets have in common: values out of the fuzzer's bytes, files out of its text, and
/// what counts as a clear refusal.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <limits>
#include <stdexcept>
#include <string>

namespace predictive_stereo {

/// Takes values from the front, so that seeds can be written by hand. Gives zeros when all is used.
class Bytes {
 public:
  Bytes(const uint8_t* data, size_t size) : data_(data), size_(size) {}

  size_t left() const { return size_; }
  uint8_t byte() {
    if (size_ == 0) return 0;
    --size_;
    return *data_++;
  }
  template <class T>
  T raw() {
    uint8_t bytes[sizeof(T)];
    for (uint8_t& b : bytes) b = byte();
    T value;
    std::memcpy(&value, bytes, sizeof(T));
    return value;
  }
  /// Uniform within [smallest, largest].
  int whole(int smallest, int largest) {
    return smallest +
           static_cast<int>(raw<uint16_t>() % static_cast<unsigned>(largest - smallest + 1));
  }
  /// Mostly what a calibration has, sometimes what nobody should write.
  double number(double usual) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    switch (byte() % 16) {
      case 1:
        return 0;
      case 2:
        return -usual;
      case 3:
        return std::numeric_limits<double>::quiet_NaN();
      case 4:
        return kInfinity;
      case 5:
        return -kInfinity;
      case 6:
        return std::numeric_limits<double>::max();
      case 7:
        return std::numeric_limits<double>::denorm_min();
      case 8:
        return raw<double>();
      case 9:
        return raw<int32_t>();
      case 10:
        return usual * raw<uint8_t>() / 64.0;
      default:
        return usual;
    }
  }

 private:
  const uint8_t* data_;
  size_t size_;
};

/// A text as a file in memory.
class MemoryFile {
 public:
  MemoryFile(const uint8_t* data, size_t size) : file_(memfd_create("fuzz", 0)) {
    if (file_ < 0 || write(file_, data, size) != static_cast<ssize_t>(size)) std::abort();
  }
  ~MemoryFile() { close(file_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  std::string path() const { return "/proc/self/fd/" + std::to_string(file_); }

 private:
  int file_;
};

/// Ends the process, which the fuzzer takes for a finding.
[[noreturn]] inline void finding(const std::string& text) {
  std::cerr << "finding: " << text << std::endl;
  std::abort();
}

/// Runs `work`, which may refuse its input: by one of the two exceptions that the interfaces
/// promise, with a sentence. Whatever else it throws is a finding (std::stoi throws its own name).
template <class Work>
void mayRefuse(const Work& work) {
  const auto check = [](const std::string& text) {
    // What ros::Time throws begins so. Further behind, it may be a word of the input that we name.
    const bool of_ros_time =
        text.rfind("Time is out of", 0) == 0 || text.rfind("Duration is out of", 0) == 0;
    if (text.find(' ') == std::string::npos || of_ros_time)
      finding("\"" + text + "\" tells nobody what is wrong");
  };
  try {
    work();
  } catch (const std::invalid_argument& error) {
    check(error.what());
  } catch (const std::runtime_error& error) {
    check(error.what());
  }
}

}  // namespace predictive_stereo
