/// Predicts the time of a frame on more cores than this machine may have.
///
/// Parallel loops and tasks of the pipeline run one after the other here, and the time of each task
/// is measured. They are then scheduled on N cores: a free core takes the next task, a loop ends
/// with its last task, and the code between loops is serial. The code divides its work as on N
/// cores. The prediction ignores shared caches and memory bandwidth; compare the column of 2 cores
/// with a measurement.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <memory>
#include <opencv2/core/parallel/parallel_backend.hpp>
#include <opencv2/core/utility.hpp>
#include <string>
#include <utility>
#include <vector>

#include "benchmark/sequences.h"
#include "benchmark/timing.h"
#include "parallel/tasks.h"
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
constexpr int kAnyCores = 1 << 20;

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
using Chain = std::vector<Step>;        ///< one after the other
using Section = std::vector<Chain>;     ///< at the same time
using Timeline = std::vector<Section>;  ///< one after the other

/// Executes loops and tasks serially and measures their times.
class Recorder {
 public:
  void begin(int cores) {
    cores_ = cores;
    timeline_.assign(1, Section(1));
    frame_ms_ = last_ms_ = nowMs();
  }
  Timeline end() {
    endSerialPart();
    return timeline_;
  }
  int cores() const { return cores_; }

  template <class Body>
  void loop(int count, const Body& body) {
    if (in_loop_) return body(0, count);  // a loop in a task counts as serial work of this task
    in_loop_ = true;
    Step& step = endSerialPart();
    for (int i = 0; i < count; ++i) {
      body(i, i + 1);
      step.task_ms.push_back(lap());
    }
    in_loop_ = false;
  }
  void together(const std::function<void()>& here, const std::function<void()>& beside) {
    endSerialPart();
    timeline_.emplace_back(1);
    here();
    endSerialPart();
    timeline_.back().emplace_back();
    beside();
    endSerialPart();
    timeline_.emplace_back(1);
  }

 private:
  double lap() {
    const double before = std::exchange(last_ms_, nowMs());
    return last_ms_ - before;
  }
  Step& endSerialPart() {
    const double begin_ms = last_ms_ - frame_ms_;
    return timeline_.back().back().emplace_back(Step{begin_ms, lap(), {}});
  }

  int cores_ = 1;
  bool in_loop_ = false;
  double frame_ms_ = 0, last_ms_ = 0;
  Timeline timeline_;
};

class RecordedTasks : public TaskRunner {
 public:
  explicit RecordedTasks(Recorder& recorder) : recorder_(recorder) {}
  void loop(int count, const std::function<void(int, int)>& body) override {
    recorder_.loop(count, body);
  }
  void together(const std::function<void()>& here, const std::function<void()>& beside) override {
    recorder_.together(here, beside);
  }

 private:
  Recorder& recorder_;
};

/// Loops of OpenCV's own functions.
class RecordedOpenCv : public cv::parallel::ParallelForAPI {
 public:
  explicit RecordedOpenCv(Recorder& recorder) : recorder_(recorder) {}
  void parallel_for(int tasks, FN_parallel_for_body_cb_t body, void* data) override {
    recorder_.loop(tasks, [&](int begin, int end) { body(begin, end, data); });
  }
  int getThreadNum() const override { return 0; }
  int getNumThreads() const override { return recorder_.cores(); }
  int setNumThreads(int) override { return recorder_.cores(); }
  const char* getName() const override { return "recorder"; }

 private:
  Recorder& recorder_;
};

/// Schedules the chains of a section: a free core takes what can start, of the first chain first.
class Schedule {
 public:
  Schedule(const Section& section, int cores, double loop_ms) : free_(cores), loop_ms_(loop_ms) {
    for (const Chain& chain : section) states_.push_back({&chain});
  }

  /// @return when the last task has ended.
  double run() {
    while (true) {
      for (State& state : states_) start(state);
      const auto next = std::min_element(running_.begin(), running_.end());
      if (next == running_.end()) return now_;
      now_ = next->first;
      State& state = *next->second;
      running_.erase(next);
      ++free_;
      end(state);
    }
  }

 private:
  struct State {
    const Chain* chain;
    size_t step = 0, task = 0;
    size_t running = 0;
    bool in_loop = false;
  };

  void start(State& state) {
    if (state.step == state.chain->size()) return;
    const Step& step = (*state.chain)[state.step];
    if (!state.in_loop && state.running == 0 && free_ > 0)
      startTask(state, step.serial_ms + (step.task_ms.size() > 1 ? loop_ms_ : 0));
    while (state.in_loop && state.task < step.task_ms.size() && free_ > 0)
      startTask(state, step.task_ms[state.task++]);
  }
  void startTask(State& state, double ms) {
    running_.emplace_back(now_ + ms, &state);
    ++state.running;
    --free_;
  }
  void end(State& state) {
    --state.running;
    state.in_loop = true;  // after the serial part
    if (state.running > 0 || state.task < (*state.chain)[state.step].task_ms.size()) return;
    ++state.step;
    state.task = 0;
    state.in_loop = false;
  }

  int free_;
  double loop_ms_, now_ = 0;
  std::vector<State> states_;
  std::vector<std::pair<double, State*>> running_;  ///< when they end
};

/// Calls visit(step, step again) for each step of two measurements of a frame.
template <class First, class Second, class Visit>
void forEachStep(First& first, Second& second, const Visit& visit) {
  const auto require = [](bool equal) {
    if (!equal) throw std::runtime_error("a frame has other loops each time");
  };
  require(first.size() == second.size());
  for (size_t section = 0; section < first.size(); ++section)
    for (size_t chain = 0; chain < first[section].size(); ++chain) {
      auto& steps = first[section][chain];
      auto& again = second[section][chain];
      require(steps.size() == again.size());
      for (size_t i = 0; i < steps.size(); ++i) visit(steps[i], again[i]);
    }
}

/// Keeps the smaller of two measurements of the same frame for each duration.
void takeLesser(const Timeline& again, Timeline& timeline) {
  forEachStep(timeline, again, [](Step& step, const Step& other) {
    step.serial_ms = std::min(step.serial_ms, other.serial_ms);
    const size_t tasks = std::min(step.task_ms.size(), other.task_ms.size());
    for (size_t t = 0; t < tasks; ++t)
      step.task_ms[t] = std::min(step.task_ms[t], other.task_ms[t]);
  });
}

/// Means over frames [ms].
struct Prediction {
  double whole = 0;   ///< on that many cores
  double serial = 0;  ///< outside loops
  double span = 0;    ///< on any number of cores
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

/// The stages in the order in which the recorder executes them.
StageTimes inOrder(const PipelineTimes& times) {
  StageTimes order = times.ego_motion;
  const auto take = [&](bool (*is_next)(const std::string&)) {
    for (const StageTime& time : times.disparity)
      if (is_next(time.name)) order.push_back(time);
  };
  take([](const std::string& name) { return name == "prediction"; });
  take([](const std::string& name) { return name != "prediction" && name != "median"; });
  order.insert(order.end(), times.detection.begin(), times.detection.end());
  take([](const std::string& name) { return name == "median"; });
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

  Recorder recorder;
  cv::parallel::setParallelForBackend(std::make_shared<RecordedOpenCv>(recorder), false);
  replaceTaskRunner(std::make_unique<RecordedTasks>(recorder));
  std::vector<Prediction> predictions;
  StageRows stages;
  for (size_t core = 0; core < std::size(kCores); ++core) {
    const int cores = kCores[core];
    std::vector<Timeline> best(frames.size());
    std::vector<StageTimes> laps(frames.size());
    for (int round = 0; round < rounds; ++round) {
      Pipeline pipeline{PipelineParams()};
      PipelineOutput output;
      for (size_t i = 0; i < frames.size(); ++i) {
        const StereoFrame frame = stereoFrame(*sequence, static_cast<int>(i), frames[i]);
        recorder.begin(cores);
        pipeline.process(frame, output);
        const Timeline timeline = recorder.end();
        if (round == 0) {
          best[i] = timeline;
          laps[i] = inOrder(pipeline.times());
        } else {
          takeLesser(timeline, best[i]);
        }
      }
    }
    const double share = 1.0 / static_cast<double>(frames.size() - kFramesBefore);
    Prediction prediction;
    for (size_t i = kFramesBefore; i < frames.size(); ++i) {
      const double overhead_ms = cores > 1 ? loop_ms : 0;
      for (const Section& section : best[i]) {
        prediction.whole += share * Schedule(section, cores, overhead_ms).run();
        prediction.span += share * Schedule(section, kAnyCores, 0).run();
      }
      forEachStep(best[i], best[i], [&](const Step& step, const Step&) {
        // A serial part counts for the stage in which it ends.
        const std::string stage = stageAt(laps[i], step.begin_ms + step.serial_ms);
        entry(stages, stage, core) +=
            share * Schedule(Section{Chain{step}}, cores, overhead_ms).run();
        entry(stages, stage + ", serial", core) += share * step.serial_ms;
        prediction.serial += share * step.serial_ms;
        prediction.loops += share * (step.task_ms.size() > 1 && cores > 1);
      });
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
  predictive_stereo::keepFreedMemory();
  return predictive_stereo::runTool(argc, argv, predictive_stereo::kHelp, predictive_stereo::run);
}
