/// What evaluateDetection found, as tables, CSV, pictures and an HTML page.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "evaluation/detection_evaluation.h"
#include "evaluation/table.h"

namespace predictive_stereo {

/// Recall, precision and errors: of all, by direction of motion, by distance.
Table scoreTable(const DetectionEvaluation& evaluation);
/// All sequences as one.
Table scoreTable(const std::vector<DetectionEvaluation>& evaluations);

/// One line a sequence and one for all of them as one: recall and precision at IoU 0.3 and 0.5.
Table pooledTable(const std::vector<DetectionEvaluation>& evaluations);

/// What became of boxes by their score: a detector whose score is a probability has the same
/// figures in both columns.
Table reliabilityTable(const std::vector<DetectionEvaluation>& evaluations);

/// The same sequences under one perturbation.
struct PerturbedEvaluation {
  std::string perturbation;
  std::vector<DetectionEvaluation> evaluations;
};
/// Recall and precision of all sequences as one under each perturbation, their means and standard
/// deviations over the perturbations.
Table perturbationTable(const std::vector<PerturbedEvaluation>& runs);
/// Means and standard deviations of each sequence over the perturbations.
Table spreadTable(const std::vector<PerturbedEvaluation>& runs);

/// Slowest speeds that the default scheme can see with a sequence's camera; see detectableSpeed.
Table limitsTable(const Sequence& sequence, const PipelineParams& params);

/// One line a sequence and group, with a header; the last sequence is "all".
std::string csv(const std::vector<DetectionEvaluation>& evaluations);
/// One line a label and one a detected object of each frame, with its outcome.
std::string framesCsv(const std::vector<DetectionEvaluation>& evaluations);

/// The left image with labels (thin: demanded white, missed magenta, tolerated grey, parked blue)
/// and detected boxes (thick: right green, tolerated yellow, false red).
cv::Mat3b picture(const cv::Mat1b& left, const EvaluatedFrame& frame);

struct FramePicture {
  std::string file;  ///< as the page refers to it
  std::string caption;
};
/// @param limits  see limitsTable.
/// @param pictures  those to show.
/// @param provenance  how it was made: shown at the end.
std::string htmlPage(const std::vector<DetectionEvaluation>& evaluations,
                     const std::vector<Table>& limits, const std::vector<FramePicture>& pictures,
                     const std::string& provenance);

}  // namespace predictive_stereo
