/// Measures the speed of the live nodelets on this machine.
#include <ros/ros.h>

#include <cstdio>
#include <opencv2/core/utility.hpp>
#include <sstream>

#include "params/yaml_params.h"
#include "tools/command_line.h"
#include "tools/live_load.h"

namespace predictive_stereo {
namespace {

constexpr int kWarmUp = 10;

double megabytes(const LoadSummary& summary) {
  return static_cast<double>(summary.resident_bytes) / 1e6;
}

double growthPercent(double before, double after) {
  return before > 0 ? 100 * (after - before) / before : 0;
}

// Latency and memory in windows of a long run, which show whether they grow.
void printWindows(const LiveLoadResult& result, int window) {
  const auto frames = static_cast<int>(result.frames.size());
  if (frames / 3 < window) return;
  std::printf("\n%15s %8s %8s %8s %8s %8s %10s\n", "frames", "lost", "p50 ms", "p95 ms", "p99 ms",
              "max ms", "memory MB");
  for (int end = window; end <= frames; end += window) {
    const LoadSummary part = result.summary(end - window, end);
    std::printf("%7d-%7d %8d %8.1f %8.1f %8.1f %8.1f %10.1f\n", end - window + 1, end, part.lost,
                part.p50_ms, part.p95_ms, part.p99_ms, part.max_ms, megabytes(part));
  }
  const LoadSummary first = result.summary(0, window), second = result.summary(window, 2 * window),
                    last = result.summary(frames - window, frames);
  std::printf("memory: %.1f MB after frame %d, %.1f MB at the end: %+.2f %%\n", megabytes(first),
              window, megabytes(last), growthPercent(megabytes(first), megabytes(last)));
  std::printf("p99 latency: %.1f ms in frames %d-%d, %.1f ms in the last %d: %+.1f %%\n",
              second.p99_ms, window + 1, 2 * window, last.p99_ms, window,
              growthPercent(second.p99_ms, last.p99_ms));
  std::printf("lost: %d of %d\n\n", result.summary().lost, frames);
}

std::vector<double> ratesFrom(const std::string& text) {
  std::vector<double> rates;
  std::istringstream list(text);
  for (std::string item; std::getline(list, item, ',');) {
    double rate = 0;
    if (item != "max") {
      parseParam("--rates", item, rate);
      if (!(rate > 0)) throw UsageError("--rates = " + text + ": each must be positive or max");
    }
    rates.push_back(rate);
  }
  if (rates.empty()) throw UsageError("--rates is empty");
  return rates;
}

}  // namespace

int runProgram(const CommandLine& line) {
  if (!line.has("bag")) throw UsageError("--bag is missing");
  if (!line.positional().empty()) throw UsageError("unexpected argument " + line.positional()[0]);
  const std::vector<double> rates = ratesFrom(line.get("rates", "10,30,max"));
  const int frames = line.getInt("frames", 300, 20);
  const int window = line.getInt("window", 1000, 10);
  AllNodeletParams params;
  params.ego_motion.sync.sync_tolerance = params.disparity.sync.sync_tolerance = 0.02;
  setFromOptions(line, params);

  ros::M_string no_remappings;
  ros::init(no_remappings, "load_test",
            ros::init_options::AnonymousName | ros::init_options::NoSigintHandler);
  if (!ros::master::check()) throw std::runtime_error("there is no ROS master: start roscore");
  catchInterruptions();
  LiveLoad load(line.get("bag"), topicChoice(line), line.getInt("pairs", 100, 2));
  std::printf("%d pairs of %dx%d, %d threads\n", load.pairs(), load.size().width,
              load.size().height, cv::getNumThreads());
  std::printf("%8s %8s %8s %8s %10s %8s %8s %8s %8s %10s\n", "asked Hz", "sent", "lost", "counted",
              "reached Hz", "p50 ms", "p95 ms", "p99 ms", "max ms", "memory MB");
  for (const double rate_hz : rates) {
    const LiveLoadResult result = load.run(rate_hz, frames, params);
    const LoadSummary all = result.summary(), warm = result.summary(kWarmUp, frames);
    const std::string asked = rate_hz > 0 ? cv::format("%.1f", rate_hz) : "max";
    std::printf("%8s %8d %8d %8ld %10.1f %8.1f %8.1f %8.1f %8.1f %10.1f\n", asked.c_str(), all.sent,
                all.lost, static_cast<long>(result.reported_losses), result.reachedHz(),
                warm.p50_ms, warm.p95_ms, warm.p99_ms, warm.max_ms, megabytes(all));
    printWindows(result, window);
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace predictive_stereo
