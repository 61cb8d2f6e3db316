/// Results of evaluateDisparity as tables, CSV and maps, for a page.
#pragma once

#include <string>
#include <vector>

#include "evaluation/disparity_evaluation.h"
#include "evaluation/report.h"

namespace predictive_stereo {

/// Names of methods that reports know.
constexpr char kOpencvHh[] = "opencv_hh";
constexpr char kOurs[] = "ours";

struct SequenceReport {
  std::string name;
  std::vector<DisparityEvaluation> evaluations;  ///< one per method
  std::vector<YAML::Node> frames;                ///< maps of some frames, see frameItem

  /// Those of `ours`; nullptr: none.
  const VarianceCalibration* variances() const;
};

/// Time and errors of each method.
Table accuracyTable(const SequenceReport& report);
/// Variances of `ours`: shares of errors within 1, 2 and 3 standard deviations, for groups of
/// pixels. Groups without pixels are left out.
Table calibrationTable(const std::vector<std::pair<std::string, VarianceCalibration>>& groups);
/// Those of the tables above that this sequence has.
std::vector<Table> tables(const SequenceReport& report);

/// One line per sequence and method, with a header.
std::string csv(const std::vector<SequenceReport>& reports);
/// One line per sequence, method and frame.
std::string framesCsv(const std::vector<SequenceReport>& reports);
/// Observed shares of errors within 0 to 3.5 standard deviations of `ours`.
std::string sharesCsv(const std::vector<SequenceReport>& reports);

/// Writes the left image and the truth of a frame into a page's folder.
YAML::Node frameItem(const SequenceFrame& frame, const std::string& title, Report& page);
/// Adds a method's maps to the frame: disparities and (ours) standard deviations, search widths
/// and, with a past, measured and predicted disparities with the boxes of the detected objects (the
/// paper's figure 4).
void addMethod(const std::string& method, const DisparityRange& range, const MethodOutput& output,
               YAML::Node frame, Report& page);

/// All results, for a page.
void add(const std::vector<SequenceReport>& reports, Report& page);

}  // namespace predictive_stereo
