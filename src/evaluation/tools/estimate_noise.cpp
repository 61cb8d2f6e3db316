/// Estimates process and measurement noise from LiDAR and writes a parameter file.
#include <boost/date_time/gregorian/gregorian.hpp>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <sstream>
#include <tuple>
#include <utility>

#include "evaluation/noise_estimation.h"
#include "evaluation/report.h"
#include "evaluation/tools/tool_input.h"
#include "tools/command_line.h"
#include "tools/output_file.h"

namespace predictive_stereo {
namespace {

namespace fs = std::filesystem;

std::string textOf(const char* name, const ErrorHistogram& errors) {
  return cv::format(
      "%s: %lld errors, mean %+.3f px, sigma %.3f px, robust sigma %.3f px, %.1f %% within "
      "1 px, %.2f %% gross (> 3 px), sigma of all %.3f px\n",
      name, static_cast<long long>(errors.count()), errors.mean_px(),
      std::sqrt(errors.variance_px2()), errors.robustSigma_px(), 100 * errors.shareWithin(1),
      100 * errors.grossShare(), std::sqrt(errors.varianceOfAll_px2()));
}

// All that was observed.
struct Observations {
  ErrorHistogram process, measurement;
  std::string provenance;  // comments of the yaml
};

void addDrive(const DriveArgument& argument, const CommandLine& command_line,
              const PipelineParams& params, Observations& all, Report& report) {
  const KittiDrive drive(argument.date_dir, argument.drive);
  std::vector<ObjectLabel> labels;
  if (command_line.has("labels"))
    labels =
        readObjectLabels((fs::path(command_line.get("labels")) / (drive.name() + ".csv")).string());
  const NoiseObservations seen =
      observeNoise(drive, labels, params, command_line.getInt("frames", 0, 2));
  const std::string process = textOf("process", seen.process),
                    measurement = textOf("measurement", seen.measurement);
  std::cout << drive.name() << "\n" << process << measurement;
  all.provenance += "# " + drive.name() + ", " + std::to_string(seen.frames) +
                    " frames with scans, moving objects " +
                    (labels.empty() ? "not masked" : "masked by labels") + "\n#   " + process +
                    "#   " + measurement;
  const std::string name = fileName(drive.name());  // stays in the report's folder
  for (const auto& [kind, errors] : {std::pair("process", &seen.process_image),
                                     std::pair("measurement", &seen.measurement_image)}) {
    const std::string file = name + "_" + kind + "_error.png";
    writePicture(report.dir() / file, errors->map());
    report.add(reportItem("error_image", file, {{"title", drive.name() + ", " + kind + " error"}}));
  }
  all.process += seen.process;
  all.measurement += seen.measurement;
}

std::string yamlOf(const Observations& all, bool all_errors) {
  namespace date = boost::gregorian;
  const char* const errors_used = all_errors ? "all errors" : "errors that are not gross";
  const auto varianceOf = [&](const ErrorHistogram& errors) {
    return all_errors ? errors.varianceOfAll_px2() : errors.variance_px2();
  };
  std::ostringstream yaml;
  yaml.precision(3);
  yaml << "# Noise, estimated from LiDAR by estimate_noise on "
       << date::to_iso_extended_string(date::day_clock::universal_day()) << ".\n"
       << all.provenance << "# all\n#   " << textOf("process", all.process) << "#   "
       << textOf("measurement", all.measurement)
       << "disparity:\n  prediction:\n    process_noise_px2: " << varianceOf(all.process)
       << "  # variance of " << errors_used << "; includes the scan noise twice\n"
       << "  correction:\n    measurement_noise_px2: " << varianceOf(all.measurement)
       << "  # variance of " << errors_used << "; includes the scan noise\n";
  return yaml.str();
}

}  // namespace

int runProgram(const CommandLine& command_line) {
  if (!command_line.has("output")) throw UsageError("--output is missing");
  const auto drives = driveArguments(command_line.positional());
  if (drives.empty()) throw UsageError("expected DATE_DIR DRIVE");
  const PipelineParams params = readParams(command_line);
  Report report(command_line.get("output"), "Noise, estimated from LiDAR", command_line.command());
  Observations all;
  for (const DriveArgument& drive : drives) addDrive(drive, command_line, params, all, report);
  const std::string yaml = yamlOf(all, command_line.has("all-errors"));
  for (const auto& [title, file, errors] :
       {std::tuple("Process noise", "process_noise.csv", &all.process),
        std::tuple("Measurement noise", "measurement_noise.csv", &all.measurement)}) {
    writeText(report.dir() / file, errors->csv());
    report.add(reportItem("errors", file, {{"title", title}}));
  }
  writeText(report.dir() / "noise.yaml", yaml);
  std::cout << yaml.substr(yaml.find("# all"));
  report.finish();
  return 0;
}

}  // namespace predictive_stereo
