/// How fast the live nodelets are on this machine.
#include <ros/ros.h>

#include <algorithm>
#include <cstdio>
#include <opencv2/core/utility.hpp>
#include <sstream>

#include "params/yaml_params.h"
#include "tools/command_line.h"
#include "tools/interruption.h"
#include "tools/live_load.h"

namespace predictive_stereo {
namespace {

constexpr char kHelp[] = R"(load_test --bag BAG [options]

Sends the stereo pairs of a bag to the three nodelets and measures how long it takes from a left
image to its moving objects, how many frames are lost, and which rate they sustain. Nodelets and
images are in one process, as in a camera driver's nodelet manager. Needs a running roscore.

  --bag BAG             bag with a rectified stereo pair; read into memory, then played forwards and
                        backwards as often as it takes
  --camera NS           topics NS/{left,right}/{image_rect,camera_info}
  --left T --right T    image topics, their camera_info beside them
                        (neither: the only camera with a known layout is taken)
  --rates A,B,...       frames per second, or max: as fast as no frame is lost (10,30,max)
  --frames N            to send at each rate (300)
  --pairs N             of the bag to use at most (100)
  --config YAML         parameters: sections ego_motion, disparity, moving_objects
  --set NAME=VALUE      one parameter, e.g. disparity/matcher/p1=12; may be repeated
  --threads N           threads of each nodelet; the default is all
  --help

Memory is that of the process after 100 frames and at the end; --frames 10000 --rates max tells
whether it grows.
)";

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const size_t index =
      std::min(values.size() - 1, static_cast<size_t>(share * static_cast<double>(values.size())));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(index),
                   values.end());
  return values[index];
}

std::vector<double> ratesFrom(const std::string& text) {
  std::vector<double> rates;
  std::istringstream list(text);
  for (std::string item; std::getline(list, item, ',');) {
    double rate = 0;
    if (item != "max") {
      parseParam("--rates", item, rate);
      if (!(rate > 0)) throw UsageError("--rates = " + text + ": each must be positive, or max");
    }
    rates.push_back(rate);
  }
  if (rates.empty()) throw UsageError("--rates is empty");
  return rates;
}

int run(const CommandLine& line) {
  if (!line.has("bag")) throw UsageError("--bag is missing");
  if (!line.positional().empty()) throw UsageError("what is " + line.positional()[0] + "?");
  const std::vector<double> rates = ratesFrom(line.get("rates", "10,30,max"));
  const int frames = line.getInt("frames", 300, 20);
  AllNodeletParams params;
  ParamTable table(params);
  params.ego_motion.sync.sync_tolerance = params.disparity.sync.sync_tolerance = 0.02;
  if (line.has("config")) setFromYamlFile(line.get("config"), table);
  for (const std::string& assignment : line.all("set")) table.setAssignment(assignment);
  if (line.has("threads")) cv::setNumThreads(line.getInt("threads", 0, 1));

  ros::M_string no_remappings;
  ros::init(no_remappings, "load_test",
            ros::init_options::AnonymousName | ros::init_options::NoSigintHandler);
  if (!ros::master::check()) throw std::runtime_error("there is no ROS master: start roscore");
  catchInterruptions();
  LiveLoad load(line.get("bag"), {line.get("camera"), line.get("left"), line.get("right")},
                line.getInt("pairs", 100, 2));
  std::printf("%d pairs of %dx%d, %d threads\n", load.pairs(), load.size().width,
              load.size().height, cv::getNumThreads());
  std::printf("%8s %8s %8s %8s %9s %8s %8s %8s %11s %8s\n", "asked Hz", "sent", "lost", "counted",
              "reached Hz", "p50 ms", "p95 ms", "max ms", "memory MB", "growth");
  for (const double rate_hz : rates) {
    const LiveLoadResult result = load.run(rate_hz, frames, params);
    char asked[32];
    std::snprintf(asked, sizeof(asked), rate_hz > 0 ? "%.1f" : "max", rate_hz);
    std::printf("%8s %8d %8d %8ld %10.1f %8.1f %8.1f %8.1f %11.1f %+7.2f%%\n", asked, result.sent,
                result.lost(), static_cast<long>(result.reported_losses), result.rate_hz(),
                quantile(result.latency_ms, 0.5), quantile(result.latency_ms, 0.95),
                quantile(result.latency_ms, 1.0), static_cast<double>(result.late_bytes) / 1e6,
                result.growth_percent());
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace
}  // namespace predictive_stereo

int main(int argc, char** argv) {
  using namespace predictive_stereo;
  return runTool(
      argc, argv, kHelp,
      {"bag", "camera", "left", "right", "rates", "frames", "pairs", "config", "set", "threads"},
      {}, run);
}
