#include "evaluation/disparity_report.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace predictive_stereo {
namespace {

double ratio(double a, double b) { return b > 0 ? a / b : std::nan(""); }

bool isOwn(const DisparityEvaluation& evaluation) { return evaluation.measured.frames > 0; }

std::string figure(const DisparityEvaluation* evaluation, double MeanDisparityScore::*member,
                   int decimals) {
  if (!evaluation || evaluation->score.frames == 0) return "-";
  return fixed(evaluation->score.*member, decimals);
}

std::string timeText(const DisparityEvaluation* evaluation) {
  return evaluation ? fixed(evaluation->mean_ms, 1) : "-";
}

// Adds D1 and D1f relative to opencv_hh and, for our methods, to ours_full.
template <class ScoreOf>
void addRatios(const SequenceReport& report, const DisparityEvaluation& e, const ScoreOf& scoreOf,
               std::vector<std::string>& row) {
  for (const auto* other : {report.find(kOpencvHh), isOwn(e) ? report.find(kOursFull) : nullptr})
    for (const auto d1 : {&MeanDisparityScore::d1_percent, &MeanDisparityScore::d1_filled_percent})
      row.push_back(other && e.score.frames ? fixed(ratio(scoreOf(e).*d1, scoreOf(*other).*d1), 2)
                                            : "-");
}

void addCalibration(const std::string& name, const VarianceCalibration& c, Table& table) {
  table.rows.push_back({name, fixed(100 * c.shareWithin(1), 1), fixed(100 * c.shareWithin(2), 1),
                        fixed(100 * c.shareWithin(3), 1), fixed(c.negativeLogLikelihood(), 2),
                        fixed(c.meanSigma_px(), 3), fixed(c.rms_px(), 3),
                        std::to_string(c.count())});
}

}  // namespace

const DisparityEvaluation* SequenceReport::find(const std::string& method) const {
  const auto found = std::find(methods.begin(), methods.end(), method);
  return found == methods.end() ? nullptr
                                : &evaluations[static_cast<size_t>(found - methods.begin())];
}

Table paperTable(const std::vector<SequenceReport>& reports) {
  Table table;
  table.title = "The paper's Table 2: time per image [ms] and outliers among valid pixels [%]";
  table.header = {"sequence",       "ms OpenCV 8", "ms ours 4",     "ms ours 8", "% OpenCV 8",
                  "% ours nondiag", "% ours diag", "% ours 8-path", "images"};
  const bool widened = std::any_of(reports.begin(), reports.end(), [](const SequenceReport& r) {
    return r.find(kOursWidened) || r.find(kOurs8Widened);
  });
  if (widened)
    for (const char* name : {"ms widened 4", "ms widened 8", "% widened 4", "% widened 8"})
      table.header.push_back(name);
  for (const SequenceReport& report : reports) {
    const auto *opencv = report.find(kOpencvHh), *ours = report.find(kOurs),
               *diagonal = report.find(kOursDiagonal), *all = report.find(kOurs8);
    const auto d1 = &MeanDisparityScore::d1_percent;
    table.rows.push_back({report.name, timeText(opencv), timeText(ours), timeText(all),
                          figure(opencv, d1, 2), figure(ours, d1, 2), figure(diagonal, d1, 2),
                          figure(all, d1, 2), std::to_string(report.evaluations.front().images)});
    if (!widened) continue;
    const auto *four = report.find(kOursWidened), *eight = report.find(kOurs8Widened);
    for (const std::string& cell :
         {timeText(four), timeText(eight), figure(four, d1, 2), figure(eight, d1, 2)})
      table.rows.back().push_back(cell);
  }
  return table;
}

Table accuracyTable(const SequenceReport& report) {
  Table table;
  table.title = report.name + ", " + std::to_string(report.evaluations.front().images) + " images";
  table.header = {"method", "ms",      "D1 %",     "D1f %",     "density %", "rms px",
                  "bias",   "D1 / hh", "D1f / hh", "D1 / full", "D1f / full"};
  for (size_t m = 0; m < report.methods.size(); ++m) {
    const DisparityEvaluation& e = report.evaluations[m];
    table.rows.push_back(
        {report.methods[m], fixed(e.mean_ms, 1), figure(&e, &MeanDisparityScore::d1_percent, 2),
         figure(&e, &MeanDisparityScore::d1_filled_percent, 2),
         figure(&e, &MeanDisparityScore::density_percent, 2),
         figure(&e, &MeanDisparityScore::rms_px, 3), figure(&e, &MeanDisparityScore::bias_px, 3)});
    addRatios(
        report, e, [](const DisparityEvaluation& other) { return other.score; }, table.rows.back());
  }
  return table;
}

Table regionTable(const SequenceReport& report) {
  Table table;
  table.title = report.name + ": by region";
  table.header = {"region, method", "D1 %",     "D1f %",     "density %", "rms px",
                  "D1 / hh",        "D1f / hh", "D1 / full", "D1f / full"};
  for (const auto& region : report.evaluations.front().regions)
    for (size_t m = 0; m < report.methods.size(); ++m) {
      const DisparityEvaluation& e = report.evaluations[m];
      const auto scoreOf = [&](const DisparityEvaluation& other) {
        return other.regions.at(region.first);
      };
      const MeanDisparityScore score = scoreOf(e);
      table.rows.push_back({region.first + ", " + report.methods[m], fixed(score.d1_percent, 2),
                            fixed(score.d1_filled_percent, 2), fixed(score.density_percent, 2),
                            fixed(score.rms_px, 3)});
      addRatios(report, e, scoreOf, table.rows.back());
    }
  return table;
}

Table loopTable(const SequenceReport& report) {
  Table table;
  table.title = report.name + ": searched disparities; the match alone and after the filters";
  table.header = {"method",        "mean width px",  "full search %",
                  "measured D1 %", "measured D1f %", "measured rms",
                  "filtered rms",  "ratio",          "on the same pixels"};
  for (size_t m = 0; m < report.methods.size(); ++m) {
    const DisparityEvaluation& e = report.evaluations[m];
    if (e.mean_width_px == 0) continue;
    table.rows.push_back({report.methods[m], fixed(e.mean_width_px, 1),
                          fixed(e.full_search_percent, 1), fixed(e.measured.d1_percent, 2),
                          fixed(e.measured.d1_filled_percent, 2), fixed(e.measured.rms_px, 3),
                          fixed(e.score.rms_px, 3),
                          fixed(ratio(e.score.rms_px, e.measured.rms_px), 3),
                          fixed(ratio(e.common_filtered.rms_px, e.common_measured.rms_px), 3)});
  }
  return table;
}

Table calibrationTable(const DisparityEvaluation& evaluation) {
  Table table;
  table.title =
      "Variance of ours: shares of errors within 1, 2, 3 sigma (normal: 68.3, 95.4, 99.7)";
  table.header = {"pixels", "1 sigma %",     "2 sigma %",    "3 sigma %",
                  "nll",    "mean sigma px", "rms error px", "count"};
  addCalibration("all", evaluation.variance, table);
  for (const auto& bin : evaluation.variance_by_ambiguity.bins(5))
    addCalibration("ambiguity " + fixed(bin.first, 2) + " to " + fixed(bin.last, 2),
                   bin.calibration, table);
  for (const auto& bin : evaluation.variance_by_disparity.bins(5))
    addCalibration("disparity " + fixed(bin.first, 1) + " to " + fixed(bin.last, 1) + " px",
                   bin.calibration, table);
  if (evaluation.without_variance)
    table.title += "; " + std::to_string(evaluation.without_variance) + " valid pixels have none";
  return table;
}

Table stageTable(const SequenceReport& report) {
  Table table;
  table.title = report.name + ": mean ms per stage";
  table.header = {"method"};
  std::vector<std::string> stages;  // of all methods
  for (const DisparityEvaluation& e : report.evaluations)
    for (const auto& stage : e.stage_ms)
      if (std::find(stages.begin(), stages.end(), stage.first) == stages.end())
        stages.push_back(stage.first);
  table.header.insert(table.header.end(), stages.begin(), stages.end());
  table.header.push_back("sum");
  for (size_t m = 0; m < report.methods.size(); ++m) {
    const DisparityEvaluation& e = report.evaluations[m];
    if (e.stage_ms.empty()) continue;
    std::vector<std::string> row = {report.methods[m]};
    for (const std::string& name : stages) {
      const auto stage = std::find_if(e.stage_ms.begin(), e.stage_ms.end(),
                                      [&](const auto& known) { return known.first == name; });
      row.push_back(stage == e.stage_ms.end() ? "-" : fixed(stage->second, 2));
    }
    row.push_back(fixed(e.mean_ms, 2));
    table.rows.push_back(row);
  }
  return table;
}

std::vector<Table> tables(const SequenceReport& report) {
  std::vector<Table> result = {accuracyTable(report), regionTable(report), loopTable(report)};
  const DisparityEvaluation* ours = report.find(kOurs);
  if (ours && ours->variance.count() > 0) result.push_back(calibrationTable(*ours));
  result.push_back(stageTable(report));
  result.erase(std::remove_if(result.begin(), result.end(),
                              [](const Table& table) { return table.rows.empty(); }),
               result.end());
  return result;
}

Plot errorOverTime(const SequenceReport& report) {
  Plot plot;
  plot.title = report.name + ": outliers, invalid pixels counted as such";
  plot.x_label = "frame";
  plot.y_label = "D1f [%]";
  for (size_t m = 0; m < report.methods.size(); ++m) {
    PlotSeries series;
    series.name = report.methods[m];
    for (const auto& frame : report.evaluations[m].series)
      series.points.emplace_back(frame.index, frame.d1_filled_percent);
    if (series.points.size() < 3) series.style = "markers";
    plot.series.push_back(series);
  }
  return plot;
}

Plot reliability(const DisparityEvaluation& evaluation) {
  Plot plot;
  plot.title = "Variance of ours";
  plot.x_label = "share of a normal distribution's errors within k sigma [%]";
  plot.y_label = "observed share [%]";
  PlotSeries observed, ideal;
  observed.name = "ours";
  ideal.name = "ideal";
  for (double k = 0; k <= 3.5; k += VarianceCalibration::kBinWidth) {
    const double expected = 100 * std::erf(k / std::sqrt(2.0));
    observed.points.emplace_back(expected, 100 * evaluation.variance.shareWithin(k));
    ideal.points.emplace_back(expected, expected);
  }
  plot.series = {observed, ideal};
  return plot;
}

std::string csv(const std::vector<SequenceReport>& reports) {
  std::ostringstream out;
  out << "sequence,method,region,images,ms,d1_percent,d1f_percent,density_percent,rms_px,bias_px,"
         "mean_width_px,full_search_percent,measured_d1_percent,measured_d1f_percent,"
         "measured_rms_px,within_1_sigma,within_2_sigma,within_3_sigma,nll,mean_sigma_px\n";
  for (const SequenceReport& report : reports)
    for (size_t m = 0; m < report.methods.size(); ++m) {
      const DisparityEvaluation& e = report.evaluations[m];
      const auto line = [&](const std::string& region, const MeanDisparityScore& s) {
        out << report.name << ',' << report.methods[m] << ',' << region << ',' << e.images << ','
            << e.mean_ms << ',' << s.d1_percent << ',' << s.d1_filled_percent << ','
            << s.density_percent << ',' << s.rms_px << ',' << s.bias_px;
      };
      line("all", e.score);
      if (isOwn(e))
        out << ',' << e.mean_width_px << ',' << e.full_search_percent << ','
            << e.measured.d1_percent << ',' << e.measured.d1_filled_percent << ','
            << e.measured.rms_px << ',' << e.variance.shareWithin(1) << ','
            << e.variance.shareWithin(2) << ',' << e.variance.shareWithin(3) << ','
            << e.variance.negativeLogLikelihood() << ',' << e.variance.meanSigma_px() << '\n';
      else
        out << ",,,,,,,,,,\n";
      for (const auto& region : e.regions) {
        line(region.first, region.second);
        out << ",,,,,,,,,,\n";
      }
    }
  return out.str();
}

std::string framesCsv(const std::vector<SequenceReport>& reports) {
  std::ostringstream out;
  out << "sequence,method,frame,d1_percent,d1f_percent,mean_width_px\n";
  for (const SequenceReport& report : reports)
    for (size_t m = 0; m < report.methods.size(); ++m)
      for (const auto& frame : report.evaluations[m].series)
        out << report.name << ',' << report.methods[m] << ',' << frame.index << ','
            << frame.d1_percent << ',' << frame.d1_filled_percent << ',' << frame.width_px << '\n';
  return out.str();
}

void add(const std::vector<SequenceReport>& reports, Report& page) {
  page.addText(
      "D1: outliers, off by more than 3 px and 5 %, among pixels with a disparity. D1f: the same "
      "with pixels without a disparity counted as outliers. All figures are means over frames; the "
      "first frame is left out. hh: OpenCV StereoSGBM MODE_HH with the paper's parameters; full: "
      "ours, searching all disparities under the same temporal rules.");
  page.add(paperTable(reports));
  for (const SequenceReport& report : reports) {
    page.addHeading(report.name);
    for (const Table& table : tables(report)) page.add(table);
    if (report.evaluations.front().score.frames > 0) page.add(errorOverTime(report));
    const DisparityEvaluation* ours = report.find(kOurs);
    if (ours && ours->variance.count() > 0) page.add(reliability(*ours));
    for (const Panel& panel : report.panels) page.add(panel);
  }
}

}  // namespace predictive_stereo
