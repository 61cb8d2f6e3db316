/// Predicts the time of a frame on more cores than this machine may have.
///
/// All parallel loops of the pipeline run on a backend of OpenCV that executes their tasks one
/// after the other and measures the time of each. These times are then scheduled on N cores: a free
/// core takes the next task, a loop ends with its last task, and the code between loops is serial.
/// The code divides its work as on N cores. The prediction ignores shared caches and memory
/// bandwidth; compare the column of 2 cores with a measurement.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <opencv2/core/parallel/parallel_backend.hpp>
#include <opencv2/core/utility.hpp>
#include <string>
#include <vector>

#include "benchmark/sequences.h"
#include "benchmark/timing.h"
#include "predictive_stereo/pipeline.h"
#include "tools/command_line.h"

namespace predictive_stereo {
namespace {

constexpr char kHelp[] =
    "Usage: work_and_span [options]                  a built-in synthetic street\n"
    "       work_and_span [options] DATE_DIR DRIVE   a drive of KITTI's raw recordings\n"
    "Options:\n"
    "  --frames N     at most, after two that only start the loop (default 12)\n"
    "  --rounds N     passes over them; each task counts with its shortest time (default 5)\n"
    "  --loop-us T    what a parallel loop costs beside its work [us] (default 10)\n"
    "  --help\n";

constexpr int kFramesBefore = 2;
constexpr int kCores[] = {1, 2, 4, 8, 12};

double nowMs() {
  using Milliseconds = std::chrono::duration<double, std::milli>;
  return Milliseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Serial work, and the tasks of the loop that follows it.
struct Step {
  double begin_ms;  ///< since the start of the frame
  double serial_ms;
  std::vector<double> task_ms;
};
using Steps = std::vector<Step>;

/// Executes loops serially and measures the times of their tasks.
class Recorder : public cv::parallel::ParallelForAPI {
 public:
  void begin(int cores) {
    cores_ = cores;
    steps_.clear();
    frame_ms_ = last_ms_ = nowMs();
  }
  Steps end() {
    const double now = nowMs();
    steps_.push_back({last_ms_ - frame_ms_, now - last_ms_, {}});
    return steps_;
  }

  void parallel_for(int tasks, FN_parallel_for_body_cb_t body, void* data) override {
    double before = nowMs();
    Step step{last_ms_ - frame_ms_, before - last_ms_, {}};
    for (int i = 0; i < tasks; ++i) {
      body(i, i + 1, data);
      const double now = nowMs();
      step.task_ms.push_back(now - before);
      before = now;
    }
    steps_.push_back(step);
    last_ms_ = nowMs();
  }
  int getThreadNum() const override { return 0; }
  int getNumThreads() const override { return cores_; }
  int setNumThreads(int) override { return cores_; }
  const char* getName() const override { return "recorder"; }

 private:
  int cores_ = 1;
  double frame_ms_ = 0, last_ms_ = 0;
  Steps steps_;
};

/// Time until the last task has ended, if a free core takes the next task.
double scheduled(const std::vector<double>& task_ms, int cores) {
  std::vector<double> busy_until(static_cast<size_t>(cores), 0);
  for (const double ms : task_ms) *std::min_element(busy_until.begin(), busy_until.end()) += ms;
  return *std::max_element(busy_until.begin(), busy_until.end());
}

/// Keeps the smaller of two measurements of the same frame for each duration.
void takeLesser(const Steps& again, Steps& steps) {
  if (again.size() != steps.size()) throw std::runtime_error("a frame has other loops each time");
  for (size_t i = 0; i < steps.size(); ++i) {
    steps[i].serial_ms = std::min(steps[i].serial_ms, again[i].serial_ms);
    const size_t tasks = std::min(steps[i].task_ms.size(), again[i].task_ms.size());
    for (size_t t = 0; t < tasks; ++t)
      steps[i].task_ms[t] = std::min(steps[i].task_ms[t], again[i].task_ms[t]);
  }
}

/// Means over frames [ms].
struct Prediction {
  double whole = 0;   ///< on that many cores
  double serial = 0;  ///< outside loops
  double span = 0;    ///< if each loop takes as long as its longest task
  double loops = 0;   ///< their number
};

/// Milliseconds of each stage on each of kCores, mean over frames.
using StageRows = std::vector<std::pair<std::string, std::vector<double>>>;

double& entry(StageRows& rows, const std::string& stage, size_t core) {
  auto row = std::find_if(rows.begin(), rows.end(), [&](auto& r) { return r.first == stage; });
  if (row == rows.end()) row = rows.insert(row, {stage, std::vector<double>(std::size(kCores))});
  return row->second[core];
}

/// The stage at a time of the frame; stages run one after the other.
std::string stageAt(const StageTimes& laps, double ms) {
  for (const StageTime& lap : laps) {
    if (ms < lap.ms) return lap.name;
    ms -= lap.ms;
  }
  return laps.empty() ? "" : laps.back().name;
}

/// The stages in the order in which they run: the half-resolution match waits for the prediction.
StageTimes inOrder(const StageTimes& ego_motion, const PipelineTimes& others) {
  StageTimes order = others.all();
  std::stable_partition(order.begin(), order.end(), [](const StageTime& time) {
    return std::string(time.name) == "prediction";
  });
  order.insert(order.begin(), ego_motion.begin(), ego_motion.end());
  return order;
}

int run(const CommandLine& line) {
  const int most = line.getInt("frames", 12, 1) + kFramesBefore;
  const int rounds = line.getInt("rounds", 5, 1);
  const double loop_ms = line.getDouble("loop-us", 10) / 1000;
  const auto& inputs = line.positional();
  if (!inputs.empty() && inputs.size() != 2) throw UsageError("a folder and a drive, or nothing");
  const std::unique_ptr<Sequence> sequence = inputs.empty()
                                                 ? misalignedStreet(most, {1242, 375})
                                                 : openSequence(inputs[0], inputs[1], most);
  std::vector<SequenceFrame> frames;
  for (int i = 0; i < std::min(most, sequence->frames()); ++i) frames.push_back(sequence->frame(i));
  if (frames.size() <= kFramesBefore) throw std::runtime_error("too few frames");

  const auto recorder = std::make_shared<Recorder>();
  cv::parallel::setParallelForBackend(recorder, false);
  std::vector<Prediction> predictions;
  StageRows stages;
  for (size_t core = 0; core < std::size(kCores); ++core) {
    const int cores = kCores[core];
    std::vector<Steps> best(frames.size());
    std::vector<StageTimes> laps(frames.size());
    for (int round = 0; round < rounds; ++round) {
      // A separate ego-motion, because the pipeline may run other stages beside its own one.
      EgoMotion ego_motion{EgoMotionParams()};
      PipelineParams params;
      params.parts.ego_motion = false;
      Pipeline pipeline{params};
      PipelineOutput output;
      for (size_t i = 0; i < frames.size(); ++i) {
        const StereoFrame frame = stereoFrame(*sequence, static_cast<int>(i), frames[i]);
        recorder->begin(cores);
        Stopwatch watch;
        StageTimes ego_motion_times;
        FrameSources sources;
        sources.ego_motion = ego_motion.estimate(frame.left, frame.right, frame.rig);
        watch.lap("ego-motion", ego_motion_times);
        pipeline.process(frame, output, sources);
        const Steps steps = recorder->end();
        if (round == 0) {
          best[i] = steps;
          laps[i] = inOrder(ego_motion_times, pipeline.times());
        } else {
          takeLesser(steps, best[i]);
        }
      }
    }
    const double share = 1.0 / static_cast<double>(frames.size() - kFramesBefore);
    Prediction prediction;
    for (size_t i = kFramesBefore; i < frames.size(); ++i) {
      for (const Step& step : best[i]) {
        const bool is_loop = step.task_ms.size() > 1 && cores > 1;
        const double loop = scheduled(step.task_ms, cores) + (is_loop ? loop_ms : 0);
        const double longest =
            step.task_ms.empty() ? 0 : *std::max_element(step.task_ms.begin(), step.task_ms.end());
        // A serial part counts for the stage in which it ends.
        entry(stages, stageAt(laps[i], step.begin_ms + step.serial_ms), core) +=
            share * (step.serial_ms + loop);
        entry(stages, stageAt(laps[i], step.begin_ms + step.serial_ms) + ", serial", core) +=
            share * step.serial_ms;
        prediction.whole += share * (step.serial_ms + loop);
        prediction.serial += share * step.serial_ms;
        prediction.span += share * (step.serial_ms + longest);
        prediction.loops += share * is_loop;
      }
    }
    predictions.push_back(prediction);
  }

  std::printf("%s: %zu frames; a parallel loop costs %.0f us\n\n", sequence->name().c_str(),
              frames.size() - kFramesBefore, 1000 * loop_ms);
  std::printf("| cores | ms | of 1 core | of 2 cores | serial ms | span ms | loops |\n");
  std::printf("|---:|---:|---:|---:|---:|---:|---:|\n");
  for (size_t i = 0; i < predictions.size(); ++i) {
    const Prediction& p = predictions[i];
    std::printf("| %d | %.2f | %.2f | %.2f | %.2f | %.2f | %.0f |\n", kCores[i], p.whole,
                p.whole / predictions[0].whole, p.whole / predictions[1].whole, p.serial, p.span,
                p.loops);
  }
  std::printf("\n| stage, ms on cores |");
  for (const int cores : kCores) std::printf(" %d |", cores);
  std::printf("\n|---|---:|---:|---:|---:|---:|\n");
  for (const auto& [name, ms] : stages) {
    std::printf("| %s |", name.c_str());
    for (const double value : ms) std::printf(" %.2f |", value);
    std::printf("\n");
  }
  return 0;
}

}  // namespace
}  // namespace predictive_stereo

int main(int argc, char** argv) {
  using namespace predictive_stereo;
  return runTool(argc, argv, kHelp, {"frames", "rounds", "loop-us"}, {}, run);
}
