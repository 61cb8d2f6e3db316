/// Compares moving objects with labels, for KITTI drives, bags and synthetic streets.
#include <filesystem>
#include <iostream>
#include <map>

#include "evaluation/detection_report.h"
#include "evaluation/perturbation.h"
#include "evaluation/tools/bag_sequence.h"
#include "evaluation/tools/tool_input.h"
#include "tools/output_file.h"

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
  --report DIR        writes the figures and the left images, of which scripts/report DIR makes a
                      page that shows the frames with errors; it draws all frames with labels or
                      objects into DIR/pictures

A box is correct if its IoU with a demanded object is 0.3 or more. An object is demanded from the
third frame on in which it is visible. In streets, objects are demanded that are nearer than 35 m,
faster than 2 m/s over ground (nearer than 10 m: than a fifth of the distance each second), at
least half visible, and have a box of 400 px^2 or more. Errors are medians of absolute values;
speed errors are of objects up to 25 m away.
)";

// Reads the labels of a sequence, unless it has ground truth.
void setLabels(const CommandLine& command_line, Sequence& sequence) {
  const fs::path path = command_line.get("labels");
  fs::path file = path;
  if (fs::is_directory(path)) file = path / (sequence.recording() + ".csv");
  const bool has_truth = sequence.objects(0).has_value();
  if (command_line.has("labels") && (file == path || fs::exists(file) || !has_truth))
    sequence.setLabels(readObjectLabels(file.string()));
  else if (!has_truth)
    throw UsageError(sequence.name() + ": has no labels of moving objects; give --labels CSV");
}

void requireValidChoice(const CommandLine& command_line, size_t sequences) {
  if (sequences > 1 && command_line.has("labels") && !fs::is_directory(command_line.get("labels")))
    throw UsageError("--labels = " + command_line.get("labels") +
                     ": must be a folder with NAME.csv for each of several sequences");
  if (sequences > 1 && command_line.has("objects"))
    throw UsageError("--objects: give one sequence, not " + std::to_string(sequences));
  if (command_line.has("objects") && command_line.has("perturb"))
    throw UsageError("give either --perturb or --objects, not both");
}

class Evaluator {
 public:
  Evaluator(const CommandLine& command_line, const PipelineParams& params)
      : line_(command_line), params_(params), max_frames_(command_line.getInt("frames", 0, 1)) {
    if (line_.has("report"))
      report_.emplace(line_.get("report"), "Moving objects against labels", line_.command());
    for (const Perturbation& change : perturbations())
      if (line_.has("perturb")) runs_.push_back({change.name, {}});
  }

  void add(const Sequence& sequence) {
    const bool recorded = line_.has("objects");
    if (!recorded && params_.detection.scheme == DetectionScheme::kDefault &&
        sequence.rig() != last_rig_)
      limits_.push_back(limitsTable(sequence, params_));
    last_rig_ = sequence.rig();
    const Detector detector =
        recorded ? recordedDetector(line_.get("objects"), sequence) : pipelineDetector(params_);
    evaluations_.push_back(evaluateDetection(
        sequence, detector, max_frames_,
        [&](const EvaluatedFrame& frame, const SequenceFrame& images) {
          const std::string file = filesOf(sequence) + cv::format("%06d.png", frame.index);
          if (report_) writePicture(report_->dir() / file, images.left);
        }));
    lefts_[sequence.name()] = filesOf(sequence);
    if (!runs_.empty()) addPerturbed(sequence);
  }

  void print() const {
    std::cout << scoreTables(evaluations_).back().text() << "\n"
              << pooledTable(evaluations_).text() << "\n"
              << reliabilityTable(evaluations_).text() << "\n";
    if (!runs_.empty())
      std::cout << spreadTable(runs_).text() << "\n" << perturbationTable(runs_).text() << "\n";
    for (const Table& table : limits_) std::cout << table.text();
  }

  void write() {
    if (line_.has("csv")) writeCsv(line_.get("csv"), csv(evaluations_), framesCsv(evaluations_));
    if (!report_) return;
    for (const Table& table : scoreTables(evaluations_)) report_->add(table);
    for (const Table& table : limits_) report_->add(table);
    writeText(report_->dir() / "frames.csv", framesCsv(evaluations_));
    YAML::Node boxes = reportItem("detections", "frames.csv");
    boxes["left"] = lefts_;
    report_->add(boxes);
    report_->finish();
  }

 private:
  // The left images of a sequence: followed by the frame's number.
  static std::string filesOf(const Sequence& sequence) {
    return "frames/" + fileName(sequence.name()) + "_";
  }

  void addPerturbed(const Sequence& sequence) {
    const std::shared_ptr<const Sequence> known = loadIntoMemory(sequence, max_frames_);
    for (size_t i = 0; i < runs_.size(); ++i) {
      const Perturbation& change = perturbations()[i];
      runs_[i].evaluations.push_back(
          i == 0 ? evaluations_.back()
                 : evaluateDetection(*perturbed(known, change),
                                     pipelineDetector(change.applyTo(params_)), 0, {}));
    }
  }

  const CommandLine& line_;
  const PipelineParams params_;
  const int max_frames_;
  std::optional<Report> report_;
  std::vector<DetectionEvaluation> evaluations_;
  std::map<std::string, std::string> lefts_;  // filesOf each sequence
  std::vector<PerturbedEvaluation> runs_;
  std::vector<Table> limits_;  // one per camera
  StereoRig last_rig_;
};

int evaluate(const CommandLine& command_line) {
  const PipelineParams params = readParams(command_line);
  useThreads(command_line);
  const StereoTopicChoice topics = topicChoice(command_line);
  const auto groups = openSequences(
      command_line, [&](const std::string& path) { return bagSequence(path, topics); });
  // Checks the inputs now, not after an hour of computing.
  std::vector<const Sequence*> sequences;
  for (const SequenceGroup& group : groups)
    for (const auto& sequence : group.sequences) {
      setLabels(command_line, *sequence);
      sequences.push_back(sequence.get());
    }
  requireValidChoice(command_line, sequences.size());
  makeFolderOf(command_line.get("csv"));
  Evaluator evaluator(command_line, params);
  for (const Sequence* sequence : sequences) evaluator.add(*sequence);
  evaluator.print();
  evaluator.write();
  return 0;
}

}  // namespace
}  // namespace predictive_stereo

int main(int argc, char** argv) {
  return predictive_stereo::runTool(
      argc, argv, predictive_stereo::kHelp,
      {"labels", "objects", "camera", "left", "right", "kitti2012", "street", "street-frames",
       "shift-right", "scheme", "config", "set", "frames", "threads", "csv", "report"},
      {"perturb"}, predictive_stereo::evaluate);
}
