#pragma once

#include <chrono>
#include <string>

namespace predictive_stereo {

/// A progress bar on stderr, if that is a terminal: one line that is rewritten,
/// "what  [####......]  40 %  40 of 100  1:25 left".
class Progress {
 public:
  Progress(const std::string& what, int frames);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// @param index  of the frame that was processed.
  void update(int index);

 private:
  using Clock = std::chrono::steady_clock;

  std::string what_;
  int frames_;
  bool shown_;
  bool line_open_ = false;
  Clock::time_point begin_ = Clock::now(), last_shown_;
};

/// Text of the progress bar, without control characters.
/// @param done  number of processed frames, of `frames`.
/// @param elapsed_s  since the start; there is no estimate of the remaining time in the first
///   second.
std::string progressText(const std::string& what, int done, int frames, double elapsed_s);

}  // namespace predictive_stereo
