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

// Reads the labels of a sequence, unless it has ground truth.
void setLabels(const CommandLine& command_line, Sequence& sequence) {
  const fs::path path = command_line.get("labels");
  fs::path file = path;
  if (fs::is_directory(path)) file = path / (sequence.name() + ".csv");
  const bool has_truth = sequence.objects(0).has_value();
  if (command_line.has("labels") && (file == path || fs::exists(file) || !has_truth)) {
    sequence.setLabels(readObjectLabels(file.string()));
    command_line.requireKept(file.string());  // of a folder, too
  } else if (!has_truth) {
    throw UsageError(sequence.name() + ": has no labels of moving objects; give --labels CSV");
  }
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
    if (!runs_.empty()) std::cout << perturbationTable(runs_).text() << "\n";
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

}  // namespace

int runProgram(const CommandLine& command_line) {
  const PipelineParams params = readParams(command_line);
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

}  // namespace predictive_stereo
