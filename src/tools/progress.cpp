#include "tools/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/core.hpp>

namespace predictive_stereo {
namespace {

constexpr auto kPeriod = std::chrono::milliseconds(100);  // between two updates
constexpr int kBar = 20;                                  // characters
constexpr double kEarliest_s = 1;                         // first estimate of the remaining time

// 75 s as 1:15, 3675 s as 1:01:15.
std::string clockText(double seconds) {
  const long s = std::lround(seconds);
  return s < 3600 ? cv::format("%ld:%02ld", s / 60, s % 60)
                  : cv::format("%ld:%02ld:%02ld", s / 3600, s / 60 % 60, s % 60);
}

}  // namespace

std::string progressText(const std::string& what, int done, int frames, double elapsed_s) {
  frames = std::max(1, frames);
  done = std::clamp(done, 0, frames);
  const double share = static_cast<double>(done) / frames;
  const auto full = static_cast<size_t>(share * kBar);
  std::string text = what + "  [" + std::string(full, '#') + std::string(kBar - full, '.') +
                     cv::format("]  %3d %%  %d of %d", static_cast<int>(100 * share), done, frames);
  if (done == frames)
    text += "  in " + clockText(elapsed_s);
  else if (done > 0 && elapsed_s >= kEarliest_s)
    text += "  " + clockText(elapsed_s * (frames - done) / done) + " left";
  return text;
}

Progress::Progress(const std::string& what, int frames)
    : what_(what), frames_(frames), shown_(isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (line_open_) std::fprintf(stderr, "\n");
}

void Progress::update(int index) {
  if (!shown_) return;
  const auto now = Clock::now();
  if (index + 1 < frames_ && now - last_shown_ < kPeriod) return;
  last_shown_ = now;
  const double elapsed_s = std::chrono::duration<double>(now - begin_).count();
  // The escape sequence clears the rest of a longer line.
  std::fprintf(stderr, "\r%s\033[K", progressText(what_, index + 1, frames_, elapsed_s).c_str());
  line_open_ = true;
}

}  // namespace predictive_stereo
