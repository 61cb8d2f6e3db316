/// Results of evaluateDetection as tables and CSV.
#pragma once

#include <string>
#include <vector>

#include "evaluation/detection_score.h"
#include "evaluation/report.h"

namespace predictive_stereo {

/// Recall, precision and errors of each sequence: of all objects, by direction of motion, by
/// distance. For several sequences the last table is that of all together.
std::vector<Table> scoreTables(const std::vector<DetectionEvaluation>& evaluations);

/// Recall and precision at IoU 0.3 and 0.5: one line per sequence, and one for all together.
Table pooledTable(const std::vector<DetectionEvaluation>& evaluations);

/// Share of correct boxes by score. If the score is a probability, both columns are equal.
Table reliabilityTable(const std::vector<DetectionEvaluation>& evaluations);

/// The same sequences under one perturbation.
struct PerturbedEvaluation {
  std::string perturbation;
  std::vector<DetectionEvaluation> evaluations;
};
/// Recall and precision of all sequences together for each perturbation, with means and standard
/// deviations over the perturbations.
Table perturbationTable(const std::vector<PerturbedEvaluation>& runs);

/// Slowest speeds that the default scheme can detect with a sequence's camera; see detectableSpeed.
Table limitsTable(const Sequence& sequence, const PipelineParams& params);

/// One line per sequence and group, with a header; the last sequence is "all".
std::string csv(const std::vector<DetectionEvaluation>& evaluations);
/// One line per label and per detected object of each frame, with its outcome.
std::string framesCsv(const std::vector<DetectionEvaluation>& evaluations);

}  // namespace predictive_stereo
