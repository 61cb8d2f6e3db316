/// Times the whole pipeline (ego-motion, disparity, moving objects) and OpenCV's matchers, which
/// compute only a disparity, on the same frames: alternately in one run, so that other load of the
/// machine affects all of them equally.
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <memory>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/utility.hpp>

#include "benchmark/sequences.h"
#include "benchmark/timing.h"
#include "evaluation/disparity_evaluation.h"
#include "predictive_stereo/pipeline.h"
#include "tools/command_line.h"
#include "tools/stage_table.h"

namespace predictive_stereo {
namespace {

constexpr char kHelp[] =
    "Usage: benchmark_pipeline [options]                  a built-in synthetic street\n"
    "       benchmark_pipeline [options] DATE_DIR DRIVE   a drive of KITTI's raw recordings\n"
    "       benchmark_pipeline [options] TRAINING SCENE   a scene of KITTI 2012\n"
    "Options:\n"
    "  --frames N       at most, after two that only start the loop (default 20)\n"
    "  --rounds N       OpenCV's repetitions on each frame, our passes over all (default 2)\n"
    "  --size WxH       of the synthetic street (default 1242x375)\n"
    "  --threads N      (default 2)\n"
    "  --help\n";

constexpr int kFramesBefore = 2;

std::unique_ptr<Sequence> open(const CommandLine& line, int frames) {
  const auto& inputs = line.positional();
  if (inputs.size() == 2) return openSequence(inputs[0], inputs[1], frames);
  if (!inputs.empty()) throw UsageError("a folder and a drive, or nothing is expected");
  cv::Size size(1242, 375);
  char rest = 0;
  const std::string text = line.get("size", "1242x375");
  if (std::sscanf(text.c_str(), "%dx%d%c", &size.width, &size.height, &rest) != 2)
    throw UsageError("--size = " + text + ": give it as 1242x375");
  return misalignedStreet(frames, size);
}

int run(const CommandLine& line) {
  const int most = line.getInt("frames", 20, 1) + kFramesBefore;
  const int rounds = line.getInt("rounds", 2, 1);
  const std::unique_ptr<Sequence> sequence = open(line, most);
  cv::setNumThreads(line.getInt("threads", 2, 1));
  std::vector<SequenceFrame> frames;
  for (int i = 0; i < std::min(most, sequence->frames()); ++i) frames.push_back(sequence->frame(i));
  if (frames.size() <= kFramesBefore) throw std::runtime_error("too few frames");

  const PipelineParams params;
  const DisparityRange& range = params.disparity.matcher.range;
  Pipeline pipeline(params);
  PipelineOutput output;
  StageTable stages;
  std::vector<double> ours_ms, hh_ms, three_way_ms;
  cv::Mat1f disparity_px;
  double widths = 0;
  for (int round = 0; round < rounds; ++round) {
    pipeline.reset();
    for (size_t i = 0; i < frames.size(); ++i) {
      const SequenceFrame& frame = frames[i];
      const double ms = timeOf(
          [&] { pipeline.process(stereoFrame(*sequence, static_cast<int>(i), frame), output); });
      if (i < kFramesBefore) continue;
      ours_ms.push_back(ms);
      stages.add(pipeline.times().all());
      widths += cv::mean(output.disparity.search_width_px)[0];
      hh_ms.push_back(timeOf([&] {
        opencvDisparity(frame.left, frame.right, range, cv::StereoSGBM::MODE_HH, disparity_px);
      }));
      three_way_ms.push_back(timeOf([&] {
        opencvDisparity(frame.left, frame.right, range, cv::StereoSGBM::MODE_SGBM_3WAY,
                        disparity_px);
      }));
    }
  }

  const cv::Size size = frames[0].left.size();
  const double ours = median(ours_ms);
  std::printf("%s: %zu frames of %dx%dx%d, %d threads; mean search width %.1f px\n\n",
              sequence->name().c_str(), frames.size() - kFramesBefore, size.width, size.height,
              range.count, cv::getNumThreads(), widths / static_cast<double>(ours_ms.size()));
  std::printf("| per frame | median ms | whole pipeline is faster by |\n|---|---:|---:|\n");
  std::printf("| whole pipeline: ego-motion, disparity, moving objects | %.2f | |\n", ours);
  std::printf("| OpenCV MODE_HH, disparity alone | %.2f | %.1f |\n", median(hh_ms),
              median(hh_ms) / ours);
  std::printf("| OpenCV MODE_SGBM_3WAY, disparity alone | %.2f | %.1f |\n\n", median(three_way_ms),
              median(three_way_ms) / ours);
  stages.print(std::cout);
  return 0;
}

}  // namespace
}  // namespace predictive_stereo

int main(int argc, char** argv) {
  predictive_stereo::keepFreedMemory();
  return predictive_stereo::runTool(argc, argv, predictive_stereo::kHelp, predictive_stereo::run);
}
