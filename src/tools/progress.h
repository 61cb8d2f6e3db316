#pragma once

#include <chrono>
#include <string>

namespace predictive_stereo {

/// A bar on stderr where that is a terminal, nothing where it is a file: one line that is
/// rewritten, "what  [####......]  40 %  40 of 100  1:25 left".
class Progress {
 public:
  Progress(const std::string& what, int frames);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// @param index  of the frame that was done.
  void update(int index);

 private:
  using Clock = std::chrono::steady_clock;

  std::string what_;
  int frames_;
  bool shown_;
  bool line_open_ = false;
  Clock::time_point begin_ = Clock::now(), last_shown_;
};

/// The line's text, without what rewrites it.
/// @param done       frames, of so many `frames`.
/// @param elapsed_s  since the beginning; less than a second tells too little of what is left.
std::string progressText(const std::string& what, int done, int frames, double elapsed_s);

}  // namespace predictive_stereo
