#pragma once

#include <string>

namespace predictive_stereo {

/// "what: frame 3 of 51" on stderr: one line that is rewritten on a terminal, else a line for every
/// tenth part.
class Progress {
 public:
  Progress(const std::string& what, int frames);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// @param index  of the frame that was done.
  void update(int index);

 private:
  std::string what_;
  int frames_;
  bool terminal_;
  bool line_open_ = false;
};

}  // namespace predictive_stereo
