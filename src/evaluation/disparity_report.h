/// Results of evaluateDisparity as tables, plots, CSV and one HTML page.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "evaluation/disparity_evaluation.h"
#include "evaluation/plot.h"
#include "evaluation/table.h"

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

/// A picture with its explanation.
struct Panel {
  std::string caption;
  cv::Mat3b image;
};

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

/// Outliers of each frame (the paper's Figure 5).
Plot errorOverTime(const SequenceReport& report);
/// Observed shares of errors within multiples of sigma, against those of a normal distribution.
Plot reliability(const DisparityEvaluation& evaluation);

/// One line per sequence, method and region, with a header.
std::string csv(const std::vector<SequenceReport>& reports);
/// One line per sequence, method and frame.
std::string framesCsv(const std::vector<SequenceReport>& reports);

/// All results on one page, without references to other files.
/// @param provenance  how the page was made; shown at its end.
std::string htmlPage(const std::vector<SequenceReport>& reports, const std::string& provenance);

/// Pictures of one frame and method: its disparities, its errors and (ours) its standard
/// deviations, search widths and, with a past, the difference of measured and predicted disparities
/// with the detected objects (the paper's figure 4). The first method also shows the left image.
std::vector<Panel> panelsOf(const SequenceFrame& frame, const std::string& title,
                            const std::string& method, bool first, const DisparityRange& range,
                            const MethodOutput& output);
/// A picture of half its size with its caption, as HTML.
std::string figureHtml(const Panel& panel);

}  // namespace predictive_stereo
