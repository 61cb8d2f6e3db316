/// The paper's Table 2, and more, for drives of KITTI, scenes of KITTI 2012 and synthetic streets.
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <sstream>

#include "evaluation/disparity_evaluation.h"
#include "params/yaml_params.h"
#include "tools/progress.h"
#include "tools/tool_input.h"

namespace predictive_stereo {
namespace {

constexpr char kHelp[] =
    R"(Usage: evaluate_kitti DATE_DIR DRIVE [DRIVE ...] [DATE_DIR DRIVE ...] [options]

Measures disparities against truth: KITTI raw drives against their laser scans, scenes of KITTI
2012 and synthetic streets against dense truth. Outliers are off by more than 3 px and 5 %.

  DATE_DIR DRIVE      a day's folder with calib_cam_to_cam.txt, and drives in it, e.g.
                      2011_09_26 2011_09_26_drive_0009_sync
  --kitti2012 DIR     all scenes of a KITTI 2012 "training" folder, counted as one sequence
  --street SCENE      a scene of the synthetic street; may be given several times
  --street-frames N   its number of frames (default 40)
  --methods LIST      of opencv_hh, opencv_3way, opencv_hh_aligned, ours, ours_diagonal, ours_8,
                      ours_full; comma-separated (default: all)
  --quick             only opencv_hh and ours
  --cache DIR         keeps OpenCV's disparities there, for the next run. Empty it after a change
                      of images or of row alignment.
  --config YAML       parameters of this package, as `pipeline` of the shipped files has them
  --set NAME=VALUE    one parameter, e.g. disparity/matcher/p1=12; may be given several times
  --list-parameters   prints all parameters with their values and limits, and ends
  --frames N          at most so many frames of each sequence
  --threads N         for all methods (default: all cores)
)";

std::vector<NamedMethod> chooseMethods(const CommandLine& command_line,
                                       const DisparityParams& params) {
  const std::string cache = command_line.get("cache");
  const auto ours = [](DisparityParams changed) {
    return [changed](const std::string&) { return predictiveMethod(changed); };
  };
  const auto opencv = [&](OpencvMode mode, bool aligned) {
    return [=](const std::string& sequence) {
      return opencvMethod(mode, params, aligned, cache, sequence);
    };
  };
  DisparityParams diagonal = params, all = params, full = params;
  diagonal.matcher.paths = PathSet::kDiagonal4;
  all.matcher.paths = PathSet::kAll8;
  full.search.scheme = SearchScheme::kFull;
  const std::vector<NamedMethod> known = {
      {"opencv_hh", opencv(OpencvMode::kHh, false)},
      {"opencv_3way", opencv(OpencvMode::k3Way, false)},
      {"opencv_hh_aligned", opencv(OpencvMode::kHh, true)},
      {"ours", ours(params)},
      {"ours_diagonal", ours(diagonal)},
      {"ours_8", ours(all)},
      {"ours_full", ours(full)},
  };
  std::string list = command_line.get("methods", command_line.has("quick") ? "opencv_hh,ours" : "");
  if (list.empty()) return known;
  std::vector<NamedMethod> chosen;
  std::istringstream names(list);
  for (std::string name; std::getline(names, name, ',');) {
    const auto method = std::find_if(known.begin(), known.end(),
                                     [&](const NamedMethod& m) { return m.name == name; });
    if (method == known.end()) throw UsageError("unknown method " + name);
    chosen.push_back(*method);
  }
  return chosen;
}

void printEvaluations(const std::string& name, const std::vector<NamedMethod>& methods,
                      const std::vector<DisparityEvaluation>& evaluations) {
  std::printf("%s, %d images\n", name.c_str(), evaluations.front().images);
  std::printf("  %-18s %7s %7s %7s %8s %7s %7s %7s\n", "method", "ms", "D1 %", "D1f %", "density",
              "rms px", "bias", "ratios to opencv_hh");
  const DisparityEvaluation* baseline = nullptr;
  for (size_t m = 0; m < methods.size(); ++m)
    if (methods[m].name == "opencv_hh") baseline = &evaluations[m];
  for (size_t m = 0; m < methods.size(); ++m) {
    const MeanDisparityScore& score = evaluations[m].score;
    std::printf("  %-18s %7.1f %7.2f %7.2f %8.2f %7.3f %+7.3f", methods[m].name.c_str(),
                evaluations[m].mean_ms, score.d1_percent, score.d1_filled_percent,
                score.density_percent, score.rms_px, score.bias_px);
    if (baseline)
      std::printf("  %5.2f %5.2f", score.d1_percent / baseline->score.d1_percent,
                  score.d1_filled_percent / baseline->score.d1_filled_percent);
    std::printf("\n");
    for (const auto& region : evaluations[m].regions) {
      const MeanDisparityScore& part = region.second;
      std::printf("    %-16s %7s %7.2f %7.2f %8.2f %7.3f %+7.3f", region.first.c_str(), "",
                  part.d1_percent, part.d1_filled_percent, part.density_percent, part.rms_px,
                  part.bias_px);
      if (baseline) {
        const MeanDisparityScore& other = baseline->regions.at(region.first);
        std::printf("  %5.2f %5.2f", part.d1_percent / other.d1_percent,
                    part.d1_filled_percent / other.d1_filled_percent);
      }
      std::printf("\n");
    }
  }
  for (size_t m = 0; m < methods.size(); ++m) {
    const DisparityEvaluation& e = evaluations[m];
    if (e.measured.frames == 0) continue;
    std::printf(
        "  %s: width %.1f px, full search %.1f %%; rms of inliers measured %.3f filtered %.3f "
        "(ratio %.3f; on the same pixels %.3f)\n",
        methods[m].name.c_str(), e.mean_width_px, e.full_search_percent, e.measured.rms_px,
        e.score.rms_px, e.score.rms_px / e.measured.rms_px,
        e.common_filtered.rms_px / e.common_measured.rms_px);
    std::printf("    measured D1 %.2f D1f %.2f density %.2f\n", e.measured.d1_percent,
                e.measured.d1_filled_percent, e.measured.density_percent);
    const auto printCalibration = [](const VarianceCalibration& c) {
      std::printf("%5.1f %5.1f %5.1f %% within 1, 2, 3 sigma; nll %.3f, mean sigma %.3f px\n",
                  100 * c.shareWithin(1), 100 * c.shareWithin(2), 100 * c.shareWithin(3),
                  c.negativeLogLikelihood(), c.meanSigma_px());
    };
    std::printf("    variance            ");
    printCalibration(e.variance);
    for (const auto& bin : e.variance_by_ambiguity.bins(5)) {
      std::printf("    ambiguity %.2f-%.2f ", bin.first, bin.last);
      printCalibration(bin.calibration);
    }
    for (const auto& bin : e.variance_by_disparity.bins(5)) {
      std::printf("    disparity %5.1f-%5.1f ", bin.first, bin.last);
      printCalibration(bin.calibration);
    }
    if (e.without_variance)
      std::printf("    %lld valid pixels have no variance\n",
                  static_cast<long long>(e.without_variance));
    std::printf("    ms:");
    for (const auto& stage : e.stage_ms)
      std::printf(" %s %.1f,", stage.first.c_str(), stage.second);
    std::printf(" sum %.1f\n", e.mean_ms);
  }
  std::fflush(stdout);
}

int evaluate(const CommandLine& command_line) {
  PipelineParams params = readParams(command_line);
  if (command_line.has("list-parameters")) {
    std::cout << toYaml(ParamTable(params));
    return 0;
  }
  useThreads(command_line);
  const int max_frames = command_line.getInt("frames", 0, 1);
  const auto methods = chooseMethods(command_line, params.disparity);
  const auto groups = openSequences(command_line);

  for (const SequenceGroup& group : groups) {
    std::vector<DisparityEvaluation> evaluations;
    for (const auto& sequence : group.sequences) {
      const int frames =
          max_frames > 0 ? std::min(max_frames, sequence->frames()) : sequence->frames();
      Progress progress(sequence->name(), frames);
      evaluateDisparity(
          *sequence, methods, params.disparity.matcher.range, params.ego_motion, max_frames,
          [&](int index) { progress.update(index); }, nullptr, evaluations);
    }
    printEvaluations(group.name, methods, evaluations);
  }
  return 0;
}

}  // namespace
}  // namespace predictive_stereo

int main(int argc, char** argv) {
  return predictive_stereo::runTool(argc, argv, predictive_stereo::kHelp,
                                    {"kitti2012", "street", "street-frames", "methods", "cache",
                                     "config", "set", "frames", "threads"},
                                    {"quick", "list-parameters"}, predictive_stereo::evaluate);
}
