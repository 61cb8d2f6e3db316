/// Times of the stages of a frame.
#pragma once

#include <chrono>
#include <vector>

namespace predictive_stereo {

/// Duration of one stage of one frame, for diagnostics and benchmarks.
struct StageTime {
  const char* name;
  double ms;
};
using StageTimes = std::vector<StageTime>;

/// Measures the time from its construction or the last lap to the next lap.
class Stopwatch {
 public:
  /// Appends the time [ms] since the last lap as the time of the stage `name` (a string literal).
  void lap(const char* name, StageTimes& times) {
    const auto now = Clock::now();
    times.push_back({name, std::chrono::duration<double, std::milli>(now - last_).count()});
    last_ = now;
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_ = Clock::now();
};

}  // namespace predictive_stereo
