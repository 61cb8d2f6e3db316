#include "tools/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace predictive_stereo {

Progress::Progress(const std::string& what, int frames)
    : what_(what), frames_(frames), terminal_(isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (line_open_) std::fprintf(stderr, "\n");
}

void Progress::update(int index) {
  const int done = index + 1;
  if (terminal_) {
    std::fprintf(stderr, "\r%s: frame %d of %d", what_.c_str(), done, frames_);
    line_open_ = true;
  } else if (done * 10 / frames_ > index * 10 / frames_) {
    std::fprintf(stderr, "%s: frame %d of %d\n", what_.c_str(), done, frames_);
  }
}

}  // namespace predictive_stereo
