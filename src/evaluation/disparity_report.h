/// Results of evaluateDisparity as tables, plots and CSV.
#pragma once

#include <string>
#include <vector>

#include "evaluation/disparity_evaluation.h"
#include "evaluation/report.h"

namespace predictive_stereo {

/// Names of methods that reports know. The others are compared with the first one; names of our
/// methods begin with kOurs.
constexpr char kOpencvHh[] = "opencv_hh";
constexpr char kOpencv3Way[] = "opencv_3way";
constexpr char kOpencvHhAligned[] = "opencv_hh_aligned";
constexpr char kOurs[] = "ours";
constexpr char kOursDiagonal[] = "ours_diagonal";
constexpr char kOurs8[] = "ours_8";
constexpr char kOursFull[] = "ours_full";
constexpr char kOursWidened[] = "ours_widened";  ///< without matcher/exact_ranges
constexpr char kOurs8Widened[] = "ours_8_widened";

struct SequenceReport {
  std::string name;
  std::vector<std::string> methods;
  std::vector<DisparityEvaluation> evaluations;  ///< one per method
  std::vector<Panel> panels;

  /// nullptr if that method was not run.
  const DisparityEvaluation* find(const std::string& method) const;
};

/// The paper's Table 2. With exact search ranges it also has columns for widened ones: vector code
/// searches these, so compare their times.
Table paperTable(const std::vector<SequenceReport>& reports);
/// Time and errors of each method, also relative to opencv_hh and to ours_full.
Table accuracyTable(const SequenceReport& report);
/// Errors by region; no rows if the sequence has no regions.
Table regionTable(const SequenceReport& report);
/// Search widths, and errors of the match alone and after the filters.
Table loopTable(const SequenceReport& report);
/// Variance calibration of `ours`: of all pixels, and in five bins each of ambiguity (lowest over
/// second lowest aggregated cost) and of true disparity.
Table calibrationTable(const DisparityEvaluation& evaluation);
Table stageTable(const SequenceReport& report);
/// Those of the tables above that this sequence has.
std::vector<Table> tables(const SequenceReport& report);

/// Outliers of each frame (the paper's Figure 5).
Plot errorOverTime(const SequenceReport& report);
/// Observed shares of errors within multiples of sigma, against those of a normal distribution.
Plot reliability(const DisparityEvaluation& evaluation);

/// One line per sequence, method and region, with a header.
std::string csv(const std::vector<SequenceReport>& reports);
/// One line per sequence, method and frame.
std::string framesCsv(const std::vector<SequenceReport>& reports);

/// All results, for a page.
void add(const std::vector<SequenceReport>& reports, Report& page);

}  // namespace predictive_stereo
