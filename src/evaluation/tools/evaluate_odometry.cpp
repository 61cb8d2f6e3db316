/// Compares ego-motion with true poses, for KITTI drives and synthetic streets.
#include <algorithm>
#include <cstdio>
#include <optional>

#include "evaluation/odometry_evaluation.h"
#include "evaluation/report.h"
#include "evaluation/tools/tool_input.h"
#include "tools/output_file.h"

namespace predictive_stereo {
namespace {

void print(const OdometryEvaluation& e) {
  std::printf("%s, %zu motions, %.1f m\n", e.name.c_str(), e.truth.size() - 1, e.length_m);
  std::printf("  per frame           %.4f m  %.4f deg (largest %.4f m  %.4f deg)\n",
              e.mean.translation_m, e.mean.rotation_rad * 180 / M_PI, e.largest.translation_m,
              e.largest.rotation_rad * 180 / M_PI);
  if (e.length_m > 0)
    std::printf("  length              %+.3f %% of the true one\n", e.length_error_percent);
  for (const RelativePoseError& error : e.relative)
    if (error.stretches)
      std::printf("  over %5.0f m        %.3f %%  %.5f deg/m (%d stretches)\n", error.length_m,
                  error.translation_percent, error.rotation_deg_per_m, error.stretches);
  std::printf("  normalised error    %.3f (mean of e'C^-1e / 6), median %.3f\n",
              e.mean_normalized_error, e.median_normalized_error);
  std::printf("  frames lost         %d\n", e.lost);
  std::printf("  ms per frame        mean %.2f, median %.2f, 95 %% %.2f\n", e.mean_ms, e.median_ms,
              e.p95_ms);
  std::fflush(stdout);
}

std::string csv(const std::vector<OdometryEvaluation>& evaluations) {
  Table csv = Table::ofCsv(
      "sequence,motions,length_m,translation_error_m,rotation_error_deg,"
      "largest_translation_error_m,length_error_percent,translation_error_percent,"
      "rotation_error_deg_per_m,mean_normalized_error,median_normalized_error,lost,mean_ms,"
      "median_ms,p95_ms");
  for (const OdometryEvaluation& e : evaluations) {
    // As in KITTI, over the longest segments of the path.
    const auto relative = std::find_if(e.relative.rbegin(), e.relative.rend(),
                                       [](const auto& error) { return error.stretches > 0; });
    csv.add(e.name, e.truth.size() - 1, e.length_m, e.mean.translation_m,
            e.mean.rotation_rad * 180 / M_PI, e.largest.translation_m,
            e.length_m > 0 ? row(e.length_error_percent) : row(""),
            relative == e.relative.rend()
                ? row("", "")
                : row(relative->translation_percent, relative->rotation_deg_per_m),
            e.mean_normalized_error, e.median_normalized_error, e.lost, e.mean_ms, e.median_ms,
            e.p95_ms);
  }
  return csv.csv();
}

}  // namespace

int runProgram(const CommandLine& command_line) {
  const PipelineParams params = readParams(command_line);
  const int max_frames = command_line.getInt("frames", 0, 2);
  std::optional<Report> report;
  if (command_line.has("report"))
    report.emplace(command_line.get("report"), "Paths, seen from above", command_line.command());
  std::vector<OdometryEvaluation> evaluations;
  for (const SequenceGroup& group : openSequences(command_line))
    for (const auto& sequence : group.sequences)
      evaluations.push_back(evaluateOdometry(*sequence, params.ego_motion, max_frames));
  for (const OdometryEvaluation& evaluation : evaluations) print(evaluation);
  if (report) {
    writeText(report->dir() / "paths.csv", pathsCsv(evaluations));
    report->add(reportItem("paths", "paths.csv"));
    report->finish();
  }
  if (command_line.has("csv")) writeText(command_line.get("csv"), csv(evaluations));
  return 0;
}

}  // namespace predictive_stereo
