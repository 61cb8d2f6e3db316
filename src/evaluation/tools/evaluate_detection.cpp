/// Compares moving objects with labels, for KITTI drives, bags and synthetic streets.
#include <filesystem>
#include <iostream>

#include "evaluation/detection_report.h"
#include "evaluation/perturbation.h"
#include "evaluation/tools/bag_sequence.h"
#include "evaluation/tools/tool_input.h"
#include "tools/output_file.h"
#include "tools/progress.h"

namespace predictive_stereo {
namespace {

namespace fs = std::filesystem;

constexpr char kHelp[] =
    R"(Usage: evaluate_detection BAG --labels CSV [options]
       evaluate_detection DATE_DIR DRIVE --labels CSV [options]
       evaluate_detection --street SCENE [options]

Runs the package on stereo sequences and measures its moving objects against labels: recall,
precision, false boxes per frame, IoU of boxes, id switches, errors of distance and speed; for all
objects, by direction of motion relative to the line of sight (toward, away, crossing) and by
distance. For several sequences it prints recall and precision of each one and of all together, at
IoU 0.3 and 0.5, and the share of correct boxes by score.

Sequences, one or several:
  BAG                 a bag with a rectified stereo pair; frames are its pairs, from 0. Bags of
                      street_to_bag contain ground truth and need no labels.
  DATE_DIR DRIVE      a day's folder with calib_cam_to_cam.txt, and drives in it, e.g.
                      2011_09_26 2011_09_26_drive_0009_sync; frames are the numbers of image files
  --kitti2012 DIR     all scenes of a KITTI 2012 "training" folder; nothing moves in them
  --street SCENE      a scene of the synthetic street (see street_to_bag --help)
  --street-frames N   its number of frames (default 40)
  --shift-right PX    shifts all right images to the right, as if the right camera had been turned
                      after the calibration

Labels and objects:
  --labels CSV        frame,track,class,x1,y1,x2,y2,distance_m,truncated,occluded,motion,hard with
                      this header line. Objects of class "ignore" or with hard = 1 do not count, and
                      boxes on them are not false; a box on class "static" is false. In frames
                      without labels every box is false. For several sequences give a folder with
                      NAME.csv for each drive or bag.
  --objects BAG       measures the topic moving_objects of this bag, which replay or the nodelets
                      wrote, instead of running the package. It may be the same bag. Frames without
                      a message count as frames without objects.
  --camera NS, --left T --right T
                      the topics of a bag, as in replay

Parameters:
  --scheme NAME       default or paper: the same as --set moving_objects/scheme=NAME
  --config YAML       as in config/*.yaml
  --set NAME=VALUE    one parameter, e.g. moving_objects/motion/min_tracks=5; may be repeated
  --list-parameters   prints all parameters with their values and limits, and exits
  --frames N          use at most N frames of each sequence
  --threads N         (default: all cores)

  --perturb           runs each sequence again with perturbations that should not matter: other
                      search ranges, noise, contrast, one darker image, mirrored images, wrong
                      columns, missing frames, every second frame; prints the figures of each one,
                      their mean and their standard deviation

Also printed: the slowest speeds that the default scheme can detect with this camera and frame rate,
by distance.

Results:
  --csv FILE          writes the figures, and every label and box into a second file, with _frames
                      added to its name
  --report DIR        writes the figures and the frames with errors, from which scripts/report DIR
                      makes a page, and each frame as a picture into DIR/frames

A box is correct if its IoU with a demanded object is 0.3 or more. An object is demanded from the
third frame on in which it is visible. In streets, objects are demanded that are nearer than 35 m,
faster than 2 m/s over ground, at least half visible, and have a box of 400 px^2 or more. Errors are
medians of absolute values; speed errors are of objects up to 25 m away.
)";

// Labels of one sequence; none: the sequence must have ground truth.
std::optional<std::vector<ObjectLabel>> labelsFor(const CommandLine& command_line,
                                                  const Sequence& sequence) {
  if (!command_line.has("labels")) return std::nullopt;
  const fs::path path = command_line.get("labels");
  if (!fs::is_directory(path)) return readObjectLabels(path.string());
  const fs::path file = path / (sequence.recording() + ".csv");
  if (!fs::exists(file) && sequence.objects(0)) return std::nullopt;
  return readObjectLabels(file.string());
}

/// Writes a picture of a frame into `dir`.
/// @return its file, relative to `dir`.
std::string writeFrame(const fs::path& dir, const std::string& sequence, const cv::Mat1b& left,
                       const EvaluatedFrame& frame) {
  char number[16];
  std::snprintf(number, sizeof(number), "_%06d", frame.index);
  const std::string file = "frames/" + fileName(sequence) + number + ".png";
  writePicture(dir / file, picture(left, frame));
  return file;
}

int evaluate(const CommandLine& command_line) {
  if (command_line.has("list-parameters")) {
    std::cout << listParams(command_line);
    return 0;
  }
  const PipelineParams params = readParams(command_line);
  useThreads(command_line);
  const int max_frames = command_line.getInt("frames", 0, 1);
  const StereoTopicChoice topics{command_line.get("camera"), command_line.get("left"),
                                 command_line.get("right")};
  if (topics.left.empty() != topics.right.empty())
    throw UsageError("give --left and --right together");
  const auto groups = openSequences(
      command_line, [&](const std::string& path) { return bagSequence(path, topics); });

  // Checks the inputs now, not after an hour of computing.
  std::vector<std::optional<std::vector<ObjectLabel>>> labels;
  size_t sequences = 0;
  for (const SequenceGroup& group : groups)
    for (const auto& sequence : group.sequences) {
      ++sequences;
      labels.push_back(labelsFor(command_line, *sequence));
      if (!labels.back() && !sequence->objects(0))
        throw UsageError(sequence->name() + ": has no labels of moving objects; give --labels CSV");
    }
  if (sequences > 1 && command_line.has("labels") && !fs::is_directory(command_line.get("labels")))
    throw UsageError("--labels = " + command_line.get("labels") +
                     ": must be a folder with NAME.csv for each of several sequences");
  if (sequences > 1 && command_line.has("objects"))
    throw UsageError("--objects: give one sequence, not " + std::to_string(sequences));
  if (const fs::path folder = fs::path(command_line.get("csv")).parent_path(); !folder.empty())
    makeFolder(folder);
  std::optional<Report> report;
  if (command_line.has("report"))
    report.emplace(command_line.get("report"), "Moving objects against labels",
                   command_line.command());

  const bool recorded = command_line.has("objects"), perturb = command_line.has("perturb");
  if (recorded && perturb) throw UsageError("give either --perturb or --objects, not both");
  std::vector<DetectionEvaluation> evaluations;
  std::vector<std::pair<std::string, std::string>> with_errors;  // frames: file, caption
  std::vector<PerturbedEvaluation> runs;
  for (const Perturbation& change : perturbations())
    if (perturb) runs.push_back({change.name, {}});
  std::vector<Table> limits;  // one per camera
  StereoRig last_rig;
  for (const SequenceGroup& group : groups)
    for (const auto& sequence : group.sequences) {
      if (!recorded && params.detection.scheme == DetectionScheme::kDefault &&
          sequence->rig() != last_rig)
        limits.push_back(limitsTable(*sequence, params));
      last_rig = sequence->rig();
      const Detector detector = recorded ? recordedDetector(command_line.get("objects"), *sequence)
                                         : pipelineDetector(params);
      Progress progress(sequence->name(),
                        max_frames ? std::min(max_frames, sequence->frames()) : sequence->frames());
      evaluations.push_back(evaluateDetection(
          *sequence, labels[evaluations.size()], detector, max_frames,
          [&](const EvaluatedFrame& frame, const SequenceFrame& images) {
            if (report) {
              const std::string file =
                  writeFrame(report->dir(), sequence->name(), images.left, frame);
              if (frame.hasErrors())
                with_errors.emplace_back(
                    file, sequence->name() + ", frame " + std::to_string(frame.index));
            }
            progress.update(frame.index);
          }));
      if (!perturb) continue;
      const auto known = loadIntoMemory(*sequence, labels[evaluations.size() - 1], max_frames);
      for (size_t i = 0; i < runs.size(); ++i) {
        const Perturbation& change = perturbations()[i];
        Progress steps(sequence->name() + ", " + change.name, 1);
        runs[i].evaluations.push_back(
            i == 0 ? evaluations.back()
                   : evaluateDetection(*perturbed(*known, change), std::nullopt,
                                       pipelineDetector(change.applyTo(params)), 0, {}));
        steps.update(0);
      }
    }

  if (evaluations.size() == 1)
    std::cout << scoreTable(evaluations[0]).text() << "\n";
  else
    std::cout << scoreTable(evaluations).text() << "\n";
  std::cout << pooledTable(evaluations).text() << "\n"
            << reliabilityTable(evaluations).text() << "\n";
  if (perturb)
    std::cout << spreadTable(runs).text() << "\n" << perturbationTable(runs).text() << "\n";
  for (const Table& table : limits) std::cout << table.text();
  if (command_line.has("csv"))
    writeCsv(command_line.get("csv"), csv(evaluations), framesCsv(evaluations));
  if (report) {
    add(evaluations, limits, *report);
    if (!with_errors.empty()) report->addHeading("Frames with errors");
    for (const auto& [file, caption] : with_errors) report->addPicture(file, caption);
    report->finish();
  }
  return 0;
}

}  // namespace
}  // namespace predictive_stereo

int main(int argc, char** argv) {
  return predictive_stereo::runTool(
      argc, argv, predictive_stereo::kHelp,
      {"labels", "objects", "camera", "left", "right", "kitti2012", "street", "street-frames",
       "shift-right", "scheme", "config", "set", "frames", "threads", "csv", "report"},
      {"list-parameters", "perturb"}, predictive_stereo::evaluate);
}
