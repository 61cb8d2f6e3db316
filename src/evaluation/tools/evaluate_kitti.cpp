/// Evaluates disparity on KITTI drives, scenes of KITTI 2012 and 2015, and synthetic streets.
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <opencv2/calib3d.hpp>
#include <optional>
#include <sstream>

#include "evaluation/disparity_report.h"
#include "evaluation/kitti_evaluation_2015.h"
#include "evaluation/tools/tool_input.h"
#include "tools/output_file.h"
#include "tools/progress.h"

namespace predictive_stereo {
namespace {

namespace fs = std::filesystem;

std::vector<NamedMethod> chooseMethods(const CommandLine& command_line,
                                       const PipelineParams& params) {
  const auto ours = [](PipelineParams changed) {
    return [changed] { return predictiveMethod(changed); };
  };
  const auto opencv = [&](int mode, bool aligned) {
    return [=] { return opencvMethod(mode, params.disparity, aligned); };
  };
  PipelineParams diagonal = params, all = params, full = params;
  diagonal.disparity.matcher.paths = PathSet::kDiagonal4;
  all.disparity.matcher.paths = PathSet::kAll8;
  full.disparity.search.scheme = SearchScheme::kFull;
  std::vector<NamedMethod> known = {
      {kOpencvHh, opencv(cv::StereoSGBM::MODE_HH, false)},
      {"opencv_3way", opencv(cv::StereoSGBM::MODE_SGBM_3WAY, false)},
      {"opencv_hh_aligned", opencv(cv::StereoSGBM::MODE_HH, true)},
      {kOurs, ours(params)},
      {"ours_diagonal", ours(diagonal)},
      {"ours_8", ours(all)},
      {"ours_full", ours(full)},
  };
  if (params.disparity.matcher.exact_ranges) {
    PipelineParams widened = params, all_widened = all;
    widened.disparity.matcher.exact_ranges = all_widened.disparity.matcher.exact_ranges = false;
    known.push_back({"ours_widened", ours(widened)});
    known.push_back({"ours_8_widened", ours(all_widened)});
  }
  const std::string list = command_line.get("methods");
  if (list.empty()) return known;
  std::vector<NamedMethod> chosen;
  std::istringstream names(list);
  for (std::string name; std::getline(names, name, ',');) {
    const auto method = std::find_if(known.begin(), known.end(),
                                     [&](const NamedMethod& m) { return m.name == name; });
    if (method == known.end()) {
      std::string names;
      for (const NamedMethod& m : known) names += (names.empty() ? "" : ", ") + m.name;
      throw UsageError("--methods: unknown method " + name + "; choose from " + names);
    }
    chosen.push_back(*method);
  }
  return chosen;
}

/// One pair, as frame `index` of a sequence.
MethodInput pairInput(const Sequence& scene, const SequenceFrame& pair, int index) {
  MethodInput input{index, stereoFrame(scene, index, pair), {}};
  input.camera.pose.state = PoseState::kKnown;  // the path starts here
  return input;
}

/// The left image of one pair, and disparities of each method.
void addPictures(const Sequence& scene, const std::vector<NamedMethod>& methods,
                 const DisparityRange& range, Report& report) {
  const SequenceFrame pair = scene.frame(scene.frames() - 1);
  report.add(reportItem("heading", "Scene " + scene.name()));
  const YAML::Node item = frameItem(pair, scene.name(), report);
  for (const NamedMethod& method : methods) {
    MethodOutput output;
    method.make()(pairInput(scene, pair, 0), output);
    addMethod(method.name, range, output, item, report);
  }
  report.add(item);
}

void evaluateKitti2015(const CommandLine& command_line, const PipelineParams& params,
                       const std::vector<NamedMethod>& methods) {
  const std::string training_dir = command_line.get("kitti2015");
  const DisparityRange& range = params.disparity.matcher.range;
  const auto names = listKittiScenes(KittiStereo::k2015, training_dir);
  std::optional<Report> report;
  if (command_line.has("report"))
    report.emplace(fs::path(command_line.get("report")) / "kitti2015", "KITTI 2015, single pairs",
                   command_line.command());
  KittiEvaluation2015 evaluation(methods);
  {
    Progress progress("KITTI 2015", static_cast<int>(names.size()));
    const bool as_sequence = command_line.has("kitti2015-as-sequence");
    VisualOdometry odometry(params.ego_motion, params.max_gap);
    std::vector<DisparityMethod> running;
    int index = 0;
    for (const std::string& name : names) {
      progress.update(index);
      const auto scene = kittiScene(KittiStereo::k2015, training_dir, name);
      const SequenceFrame pair = scene->frame(scene->frames() - 1);
      MethodInput input = pairInput(*scene, pair, as_sequence ? index : 0);
      if (!as_sequence || index == 0) running = startMethods(methods);
      if (as_sequence) input.camera = odometry.process(input.frame);
      evaluation.add(name, pair, input, running, range);
      ++index;
    }
  }
  const std::vector<Table> tables = {evaluation.table(), evaluation.variances(),
                                     evaluation.certaintyTable(), evaluation.worstTable()};
  for (const Table& table : tables)
    if (!table.rows.empty()) std::cout << table.text();
  if (!report) return;
  for (const Table& table : tables) report->add(table);
  for (const auto& [name, score] : evaluation.worst())
    addPictures(*kittiScene(KittiStereo::k2015, training_dir, name), methods, range, *report);
  report->finish();
}

}  // namespace

int runProgram(const CommandLine& command_line) {
  const PipelineParams params = readParams(command_line);
  const int max_frames = command_line.getInt("frames", 0, 1);
  const auto methods = chooseMethods(command_line, params);
  const auto groups = openSequences(command_line);

  // Makes folders now, not after an hour of computing.
  std::optional<Report> page;
  if (command_line.has("report"))
    page.emplace(command_line.get("report"), "Disparities against ground truth",
                 command_line.command());
  makeFolderOf(command_line.get("csv"));

  if (command_line.has("kitti2015")) evaluateKitti2015(command_line, params, methods);
  if (groups.empty()) return 0;

  const DisparityRange& range = params.disparity.matcher.range;
  std::vector<SequenceReport> reports;
  for (const SequenceGroup& group : groups) {
    SequenceReport report;
    report.name = group.name;
    for (const auto& sequence : group.sequences) {
      const int frames = framesOf(*sequence, max_frames);
      const auto addMaps = [&](const SequenceFrame& frame, int index, size_t m,
                               const MethodOutput& output) {
        const std::string& method = methods[m].name;
        if (index + 1 != frames || !(m == 0 || method == kOpencvHh || method == kOurs)) return;
        const std::string title = sequence->name() + ", frame " + std::to_string(index);
        if (m == 0) report.frames.push_back(frameItem(frame, title, *page));
        addMethod(method, range, output, report.frames.back(), *page);
      };
      evaluateDisparity(*sequence, methods, params, max_frames,
                        page ? FrameCallback(addMaps) : FrameCallback(), report.evaluations);
    }
    for (const Table& table : tables(report)) std::cout << table.text();
    std::cout << std::endl;
    reports.push_back(std::move(report));
  }
  if (command_line.has("csv")) writeCsv(command_line.get("csv"), csv(reports), framesCsv(reports));
  if (page) {
    add(reports, *page);
    page->finish();
  }
  return 0;
}

}  // namespace predictive_stereo
