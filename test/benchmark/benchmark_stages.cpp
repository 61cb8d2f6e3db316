/// Google Benchmark of every stage of the core on the synthetic street, 1242x375, 128 disparities.
/// The argument of each is the number of threads.
#include <benchmark/benchmark.h>

#include <atomic>
#include <fstream>
#include <numeric>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/utility.hpp>
#include <vector>

#include "benchmark/sequences.h"
#include "parallel/tasks.h"
#include "predictive_stereo/pipeline.h"
#include "predictive_stereo/post_filter.h"
#include "predictive_stereo/residual.h"

namespace predictive_stereo {
namespace {

/// Two frames of the street, and the inputs of each stage. The closed loop has processed the first
/// frame; the stages process the second one.
struct Inputs {
  Inputs() {
    const auto street = misalignedStreet(2);
    rig = street->rig();
    previous = street->frame(0);
    frame = street->frame(1);
    const DisparityRange& range = params.disparity.matcher.range;

    Match match;
    cv::Mat1f measured_px;
    StereoMatcher matcher(params.disparity.matcher);
    CoarseMatcher coarse_matcher(params.disparity.matcher);
    RowAligner aligner(params.disparity.row_alignment);
    const auto align = [&](const SequenceFrame& pair) {
      coarse_matcher.match(pair.left, pair.right, coarse_px);
      alignment = aligner.estimate(pair.left, pair.right, coarse_px, range);
      alignRightImage(pair.right, alignment, 0, aligned_right);
    };
    align(previous);
    matcher.match(previous.left, aligned_right, match);
    filterBySupport(range, params.disparity.min_support, match.disparity_px, measured_px);
    Predictor predictor(range, params.disparity.prediction);
    predictor.predictNothing(rig.size, prediction);
    correct(prediction, measured_px, range, params.disparity.correction, state);

    EgoMotion ego_motion(params.ego_motion);
    ego_motion.estimate(previous.left, previous.right, rig);
    motion = ego_motion.estimate(frame.left, frame.right, rig).motion;
    aligned_right.release();
    align(frame);
    predictor.predict(state, rig, motion, prediction);
    SearchRangeBuilder(range, params.disparity.search).build(prediction, coarse_px, ranges);
    matcher.match(frame.left, aligned_right, ranges, this->match);
    filterBySupport(range, params.disparity.min_support, this->match.disparity_px,
                    this->measured_px);
  }

  PipelineParams params;
  StereoRig rig;
  SequenceFrame previous, frame;
  RowOffsetModel alignment;
  cv::Mat1b aligned_right;
  cv::Mat1f coarse_px, measured_px;
  DisparityState state;
  CameraMotion motion;
  Prediction prediction;
  SearchRanges ranges;
  Match match;
};

const Inputs& inputs() {
  static const Inputs inputs;
  return inputs;
}

/// Growth of the process's resident memory since construction.
class MemoryGrowth {
 public:
  benchmark::Counter megabytes() const { return residentMb() - before_; }

 private:
  static double residentMb() {
    std::ifstream file("/proc/self/statm");
    double total = 0, resident = 0;
    file >> total >> resident;
    return resident * 4096 / 1e6;
  }
  double before_ = residentMb();
};

template <class Work>
void measure(benchmark::State& state, const Work& work) {
  inputs();
  cv::setNumThreads(static_cast<int>(state.range(0)));
  work();  // allocates
  for (auto _ : state) work();
}

void egoMotion(benchmark::State& state) {
  const Inputs& in = inputs();
  EgoMotion ego_motion(in.params.ego_motion);
  bool odd = false;
  measure(state, [&] {
    const SequenceFrame& frame = odd ? in.frame : in.previous;
    ego_motion.estimate(frame.left, frame.right, in.rig);
    odd = !odd;
  });
}

void halfResolutionMatch(benchmark::State& state) {
  const Inputs& in = inputs();
  CoarseMatcher matcher(in.params.disparity.matcher);
  cv::Mat1f coarse_px;
  measure(state, [&] { matcher.match(in.frame.left, in.frame.right, coarse_px); });
}

void rowAlignmentEstimate(benchmark::State& state) {
  const Inputs& in = inputs();
  RowAligner aligner(in.params.disparity.row_alignment);
  measure(state, [&] {
    aligner.estimate(in.frame.left, in.frame.right, in.coarse_px,
                     in.params.disparity.matcher.range);
  });
}

void rowAlignmentWarp(benchmark::State& state) {
  const Inputs& in = inputs();
  cv::Mat1b aligned;
  measure(state, [&] { alignRightImage(in.frame.right, in.alignment, 0, aligned); });
}

void prediction(benchmark::State& state) {
  const Inputs& in = inputs();
  Predictor predictor(in.params.disparity.matcher.range, in.params.disparity.prediction);
  Prediction prediction;
  measure(state, [&] { predictor.predict(in.state, in.rig, in.motion, prediction); });
}

void searchRanges(benchmark::State& state) {
  const Inputs& in = inputs();
  SearchRangeBuilder builder(in.params.disparity.matcher.range, in.params.disparity.search);
  SearchRanges ranges;
  measure(state, [&] { builder.build(in.prediction, in.coarse_px, ranges); });
}

void matchFull(benchmark::State& state, PathSet paths, CensusForm census) {
  const Inputs& in = inputs();
  const MemoryGrowth memory;
  MatcherParams params = in.params.disparity.matcher;
  params.paths = paths;
  params.census = census;
  StereoMatcher matcher(params);
  Match match;
  measure(state, [&] { matcher.match(in.frame.left, in.aligned_right, match); });
  state.counters["MB"] = memory.megabytes();
}

void matchReduced(benchmark::State& state, PathSet paths) {
  const Inputs& in = inputs();
  const MemoryGrowth memory;
  MatcherParams params = in.params.disparity.matcher;
  params.paths = paths;
  StereoMatcher matcher(params);
  Match match;
  measure(state, [&] { matcher.match(in.frame.left, in.aligned_right, in.ranges, match); });
  state.counters["MB"] = memory.megabytes();
}

void supportFilter(benchmark::State& state) {
  const Inputs& in = inputs();
  cv::Mat1f filtered_px;
  measure(state, [&] {
    filterBySupport(in.params.disparity.matcher.range, 10, in.match.disparity_px, filtered_px);
  });
}

// OpenCV's filter that the support filter replaces.
void opencvFilterSpeckles(benchmark::State& state) {
  const Inputs& in = inputs();
  cv::Mat disparity_16, filtered, buffer;
  in.match.disparity_px.convertTo(disparity_16, CV_16S, 16);
  measure(state, [&] {
    disparity_16.copyTo(filtered);
    cv::filterSpeckles(filtered, -16, 50, 16, buffer);
  });
}

void holesAndMedian(benchmark::State& state) {
  const Inputs& in = inputs();
  cv::Mat1f filled_px, filtered_px;
  measure(state, [&] {
    fillHoles(in.params.disparity.matcher.range, 40, 3, in.measured_px, filled_px);
    median3x3(in.params.disparity.matcher.range, 3, filled_px, filtered_px);
  });
}

void variance(benchmark::State& state) {
  const Inputs& in = inputs();
  cv::Mat1f variance_px2;
  measure(state, [&] {
    measurementVariance(in.measured_px, in.match.ambiguity, in.params.disparity.matcher.range,
                        in.params.disparity.variance, variance_px2);
  });
}

void photometricResidual(benchmark::State& state) {
  const Inputs& in = inputs();
  PhotometricResidual residual;
  cv::Mat1f share;
  measure(state, [&] {
    residual.measure(in.frame.left, in.frame.right, in.measured_px,
                     in.params.disparity.matcher.range, 0, share);
  });
}

void publishing(benchmark::State& state) {
  const Inputs& in = inputs();
  const cv::Size size = in.measured_px.size();
  const DisparityEvidence evidence{in.state.disparity_px,
                                   in.prediction.disparity_px,
                                   in.measured_px,
                                   cv::Mat1f(size, 0.1f),
                                   in.match.ambiguity,
                                   cv::Mat1f(size, 0.0f),
                                   0.1};
  cv::Mat1f published_px, variance_px2;
  measure(state, [&] {
    publish(in.measured_px, evidence, in.params.disparity.matcher.range,
            in.params.disparity.variance, published_px, variance_px2);
  });
}

void correction(benchmark::State& state) {
  const Inputs& in = inputs();
  DisparityState filters;
  measure(state, [&] {
    correct(in.prediction, in.measured_px, in.params.disparity.matcher.range,
            in.params.disparity.correction, filters);
  });
}

constexpr std::chrono::milliseconds kFramePeriod(100);

void disparityLoop(benchmark::State& state) {
  const Inputs& in = inputs();
  const MemoryGrowth memory;
  DisparityLoop loop(in.params.disparity, in.params.max_gap);
  DisparityOutput maps;
  // The cost of the loop: the same frame repeatedly, with the motion of a standing camera.
  Stamp stamp{};
  measure(state, [&] {
    stamp += kFramePeriod;
    loop.process(
        {in.frame.left, in.frame.right, in.rig, stamp}, [](const Past&) { return CameraMotion(); },
        maps);
  });
  state.counters["MB"] = memory.megabytes();
}

/// Some frames of the street, for stages that need successive frames.
struct Drive {
  Drive() {
    constexpr int kFrames = 6;
    const auto street = misalignedStreet(kFrames);
    rig = street->rig();
    Pipeline pipeline{PipelineParams()};
    for (int i = 0; i < kFrames; ++i) {
      frames.push_back(street->frame(i));
      PipelineOutput output;
      pipeline.process({frames[i].left, frames[i].right, rig, i * kFramePeriod}, output);
      outputs.push_back(output);
    }
  }
  StereoRig rig;
  std::vector<SequenceFrame> frames;
  std::vector<PipelineOutput> outputs;
};

const Drive& drive() {
  static const Drive drive;
  return drive;
}

/// Times work(index) for successive frames, and starts again after the last one.
template <class Work, class Restart>
void measureDrive(benchmark::State& state, const Work& work, const Restart& restart) {
  size_t index = 0;
  measure(state, [&] {
    if (index == drive().frames.size()) {
      restart();
      index = 0;
    }
    work(index++);
  });
}

void movingObjects(benchmark::State& state) {
  const Drive& in = drive();
  MovingObjectDetector detector{DetectionParams()};
  Detections detections;
  measureDrive(
      state,
      [&](size_t i) {
        const PipelineOutput& frame = in.outputs[i];
        const DisparityOutput& maps = frame.disparity;
        detector.detect(
            {0.1 * static_cast<double>(i), in.rig, in.frames[i].left, maps.measured_disparity_px,
             maps.measured_variance_px2, maps.predicted_disparity_px, maps.predicted_variance_px2,
             frame.pose.state, frame.pose.T_odom_cam},
            detections);
      },
      [&] { detector.reset(); });
}

// Computed on demand, for visualisation.
void residualImage(benchmark::State& state) {
  const DisparityOutput& maps = drive().outputs.back().disparity;
  cv::Mat1f residual;
  measure(state, [&] {
    normalizedResidual(maps.measured_disparity_px, maps.measured_variance_px2,
                       maps.predicted_disparity_px, maps.predicted_variance_px2, DisparityRange(),
                       residual);
  });
}

void wholePipeline(benchmark::State& state) {
  const Drive& in = drive();
  const MemoryGrowth memory;
  Pipeline pipeline{PipelineParams()};
  PipelineOutput output;
  measureDrive(
      state,
      [&](size_t i) {
        const SequenceFrame& frame = in.frames[i];
        pipeline.process({frame.left, frame.right, in.rig, i * kFramePeriod}, output);
      },
      [&] { pipeline.reset(); });
  state.counters["MB"] = memory.megabytes();
}

// Memory bandwidth: the cost volume of a full search, written once and read once.
void memoryOfAFullSearch(benchmark::State& state) {
  const Inputs& in = inputs();
  const auto bytes = static_cast<size_t>(in.rig.size.area()) *
                     static_cast<size_t>(in.params.disparity.matcher.range.count);
  std::vector<uint64_t> volume(bytes / sizeof(uint64_t));
  measure(state, [&] {
    parallelFor({0, 16}, [&](const cv::Range& parts) {
      const auto begin = volume.begin() + static_cast<ptrdiff_t>(volume.size() / 16 * parts.start);
      const auto end = volume.begin() + static_cast<ptrdiff_t>(volume.size() / 16 * parts.end);
      std::fill(begin, end, parts.start);
    });
    std::atomic<uint64_t> sum = 0;
    parallelFor({0, 16}, [&](const cv::Range& parts) {
      const auto begin = volume.begin() + static_cast<ptrdiff_t>(volume.size() / 16 * parts.start);
      const auto end = volume.begin() + static_cast<ptrdiff_t>(volume.size() / 16 * parts.end);
      sum += std::accumulate(begin, end, uint64_t{0});
    });
    benchmark::DoNotOptimize(sum.load());
  });
  state.counters["MB"] = static_cast<double>(2 * bytes) / 1e6;
}

#define TIMED ->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime()
#define STAGE(stage) BENCHMARK(stage) TIMED
#define VARIANT(stage, ...) BENCHMARK_CAPTURE(stage, __VA_ARGS__) TIMED

STAGE(egoMotion);
STAGE(halfResolutionMatch);
STAGE(rowAlignmentEstimate);
STAGE(rowAlignmentWarp);
STAGE(prediction);
STAGE(searchRanges);
VARIANT(matchFull, straight_4, PathSet::kStraight4, CensusForm::kCentreSymmetric9x5);
VARIANT(matchFull, straight_4_census_5x5, PathSet::kStraight4, CensusForm::k5x5);
VARIANT(matchFull, straight_4_census_mixed, PathSet::kStraight4, CensusForm::kMixed9x5);
VARIANT(matchFull, diagonal_4, PathSet::kDiagonal4, CensusForm::kCentreSymmetric9x5);
VARIANT(matchFull, all_8, PathSet::kAll8, CensusForm::kCentreSymmetric9x5);
VARIANT(matchReduced, straight_4, PathSet::kStraight4);
VARIANT(matchReduced, all_8, PathSet::kAll8);
STAGE(supportFilter);
STAGE(opencvFilterSpeckles);
STAGE(holesAndMedian);
STAGE(variance);
STAGE(photometricResidual);
STAGE(publishing);
STAGE(correction);
STAGE(disparityLoop);
STAGE(movingObjects);
STAGE(residualImage);
STAGE(wholePipeline);
STAGE(memoryOfAFullSearch);

}  // namespace
}  // namespace predictive_stereo

BENCHMARK_MAIN();
