/// Times OpenCV's matchers and ours on the same pairs, alternately in one run, so that other load
/// of the machine affects all of them equally. The reduced search gets the ranges of the pipeline:
/// the union of the prediction and the half-resolution match.
#include <cstdio>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "benchmark/matcher_accuracy.h"
#include "benchmark/matcher_growth.h"
#include "benchmark/matcher_times.h"
#include "benchmark/matching_jobs.h"
#include "benchmark/sequences.h"
#include "benchmark/timing.h"

namespace predictive_stereo {
namespace {

const char kUsage[] =
    "Usage: benchmark_matchers [options]                  a built-in synthetic street\n"
    "       benchmark_matchers [options] LEFT RIGHT       two image files\n"
    "       benchmark_matchers [options] DATE_DIR DRIVE   a drive of KITTI's raw recordings\n"
    "       benchmark_matchers [options] TRAINING SCENE   a scene of KITTI 2012\n"
    "Options:\n"
    "  --frames N       measured frames, after two that only start the loop (default 4)\n"
    "  --rounds N       repetitions on each frame (default 5)\n"
    "  --size WxH       of the synthetic street (default 1242x375)\n"
    "  --disparities N  a multiple of 16, at most 256 (default 128)\n"
    "  --no-times       accuracy only, on as many frames as are asked for\n"
    "  --no-growth      leave out how times grow with area, disparities, width, threads\n"
    "  --help\n";

struct Options {
  std::vector<std::string> inputs;
  int frames = 4;
  int rounds = 5;
  cv::Size size{1242, 375};
  int disparities = 128;
  bool times = true;
  bool growth = true;
};

struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

Options parse(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const auto value = [&]() -> std::string {
      if (++i == argc) throw UsageError(word + " needs a value");
      return argv[i];
    };
    const auto number = [&] {
      const std::string text = value();
      try {
        size_t end = 0;
        const int n = std::stoi(text, &end);
        if (end == text.size() && n > 0) return n;
      } catch (const std::logic_error&) {
      }
      throw UsageError(word + " " + text + ": must be a positive number");
    };
    if (word == "--frames")
      options.frames = number();
    else if (word == "--rounds")
      options.rounds = number();
    else if (word == "--disparities")
      options.disparities = number();
    else if (word == "--no-times")
      options.times = options.growth = false;
    else if (word == "--no-growth")
      options.growth = false;
    else if (word == "--size") {
      const std::string text = value();
      if (std::sscanf(text.c_str(), "%dx%d", &options.size.width, &options.size.height) != 2)
        throw UsageError("--size " + text + ": must be like 1242x375");
    } else if (word.rfind("-", 0) == 0)
      throw UsageError("unknown option " + word);
    else
      options.inputs.push_back(word);
  }
  if (options.inputs.size() != 0 && options.inputs.size() != 2)
    throw UsageError("two image files, a folder and a drive, or nothing is expected");
  return options;
}

std::unique_ptr<Sequence> open(const Options& options) {
  const int frames = options.frames + kFramesBefore;
  return options.inputs.empty() ? misalignedStreet(frames, options.size)
                                : openSequence(options.inputs[0], options.inputs[1], frames);
}

void run(const Options& options) {
  DisparityParams params;
  params.matcher.range.count = options.disparities;
  const std::unique_ptr<Sequence> sequence = open(options);
  const std::vector<MatchingJob> jobs =
      matchingJobs(*sequence, params, options.frames + kFramesBefore);
  std::printf("%s, %dx%d, %d disparities, %zu frames, %d rounds; SIMD target %s; OpenCV %s\n",
              sequence->name().c_str(), sequence->rig().size.width, sequence->rig().size.height,
              params.matcher.range.count, jobs.size(), options.rounds,
              StereoMatcher(params.matcher).simdTarget().c_str(), CV_VERSION);

  if (options.times) {
    MatcherTimes times(sequence->rig(), params);
    times.measure(jobs, options.rounds, {1, 2});
    times.print({1, 2});
  }
  printMatcherAccuracy(jobs, params);
  if (options.growth) printMatcherGrowth(jobs.back(), params.matcher, options.rounds);
}

}  // namespace
}  // namespace predictive_stereo

int main(int argc, char** argv) {
  using namespace predictive_stereo;
  keepFreedMemory();
  try {
    for (int i = 1; i < argc; ++i)
      if (std::string(argv[i]) == "--help") {
        std::fputs(kUsage, stdout);
        return 0;
      }
    run(parse(argc, argv));
  } catch (const UsageError& error) {
    std::fprintf(stderr, "benchmark_matchers: %s\n%s", error.what(), kUsage);
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "benchmark_matchers: %s\n", error.what());
    return 1;
  }
  return 0;
}
