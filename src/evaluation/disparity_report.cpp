#include "evaluation/disparity_report.h"

#include "evaluation/statistics.h"
#include "tools/output_file.h"

namespace predictive_stereo {

const VarianceCalibration* SequenceReport::variances() const {
  for (const DisparityEvaluation& e : evaluations)
    if (e.method == kOurs && e.variance.count() > 0) return &e.variance;
  return nullptr;
}

Table accuracyTable(const SequenceReport& report) {
  Table table{report.name + ", " + std::to_string(report.evaluations.front().images) + " images",
              {"method", "ms", "D1 %", "D1f %", "density %", "rms px"}};
  for (const DisparityEvaluation& e : report.evaluations) {
    const MeanDisparityScore& s = e.score;
    table.add(e.method, fixed(e.mean_ms, 1),
              s.frames ? row(fixed(s.d1_percent, 2), fixed(s.d1_filled_percent, 2),
                             fixed(s.density_percent, 2), fixed(s.rms_px, 3))
                       : Row(4, "-"));
  }
  return table;
}

Table calibrationTable(const std::vector<std::pair<std::string, VarianceCalibration>>& groups) {
  Table table{"Variance of ours: shares of errors within 1, 2, 3 sigma (normal: 68.3, 95.4, 99.7)",
              {"pixels", "1 sigma %", "2 sigma %", "3 sigma %", "mean sigma px", "count"}};
  for (const auto& [name, c] : groups)
    if (c.count() > 0)
      table.add(name, fixed(100 * c.shareWithin(1), 1), fixed(100 * c.shareWithin(2), 1),
                fixed(100 * c.shareWithin(3), 1), fixed(c.meanSigma_px(), 3), c.count());
  return table;
}

std::vector<Table> tables(const SequenceReport& report) {
  std::vector<Table> result = {accuracyTable(report)};
  if (report.variances()) result.push_back(calibrationTable({{"all", *report.variances()}}));
  return result;
}

std::string csv(const std::vector<SequenceReport>& reports) {
  Table csv = Table::ofCsv(
      "sequence,method,images,ms,d1_percent,d1f_percent,density_percent,rms_px,"
      "mean_width_px,measured_rms_px,within_1_sigma,within_2_sigma,within_3_sigma,nll,"
      "mean_sigma_px");
  for (const SequenceReport& report : reports)
    for (const DisparityEvaluation& e : report.evaluations) {
      const MeanDisparityScore& s = e.score;
      Row own;
      if (e.measured.frames > 0)  // a method of this package
        own = row(e.mean_width_px, e.measured.rms_px, e.variance.shareWithin(1),
                  e.variance.shareWithin(2), e.variance.shareWithin(3),
                  e.variance.negativeLogLikelihood(), e.variance.meanSigma_px());
      csv.add(report.name, e.method, e.images, e.mean_ms, s.d1_percent, s.d1_filled_percent,
              s.density_percent, s.rms_px, own);
    }
  return csv.csv();
}

std::string framesCsv(const std::vector<SequenceReport>& reports) {
  Table csv = Table::ofCsv("sequence,method,frame,d1_percent,d1f_percent,mean_width_px");
  for (const SequenceReport& report : reports)
    for (const DisparityEvaluation& e : report.evaluations)
      for (const auto& frame : e.series)
        csv.add(report.name, e.method, frame.index, frame.d1_percent, frame.d1_filled_percent,
                frame.width_px);
  return csv.csv();
}

std::string sharesCsv(const std::vector<SequenceReport>& reports) {
  Table csv = Table::ofCsv("sequence,sigmas,share");
  for (const SequenceReport& report : reports)
    if (const VarianceCalibration* ours = report.variances())
      for (double k = 0; k <= 3.5; k += VarianceCalibration::kBinWidth)
        csv.add(report.name, k, ours->shareWithin(k));
  return csv.csv();
}

YAML::Node frameItem(const SequenceFrame& frame, const std::string& title, Report& page) {
  YAML::Node item = reportItem("frame", title);
  item["left"] = page.write(frame.left);
  if (!frame.truth_px.empty()) item["truth"] = page.writeMap(frame.truth_px, frame.truth_px >= 0);
  return item;
}

void addMethod(const std::string& method, const DisparityRange& range, const MethodOutput& output,
               YAML::Node frame, Report& page) {
  const DisparityOutput& maps = output.maps;
  const auto write = [&](const cv::Mat1f& disparity_px) {
    return page.writeMap(disparity_px, disparity_px >= range.min_disparity);
  };
  YAML::Node item = reportItem("name", method);
  item["disparity"] = write(maps.disparity_px);
  if (!maps.disparity_variance_px2.empty()) {
    cv::Mat1f sigma_px;
    cv::sqrt(maps.disparity_variance_px2, sigma_px);
    item["sigma"] = page.writeMap(sigma_px, maps.disparity_px >= range.min_disparity);
    item["width"] = page.writeMap(maps.search_width_px, maps.search_width_px >= 0);
    item["range"] = range.count;
  }
  if (maps.predicted) {
    item["measured"] = write(maps.measured_disparity_px);
    item["predicted"] = write(maps.predicted_disparity_px);
    for (const DetectedObject& object : output.objects) {
      const cv::Rect box(object.box_px);
      item["boxes"].push_back(std::vector<int>{box.x, box.y, box.width, box.height});
    }
  }
  frame["methods"].push_back(item);
}

void add(const std::vector<SequenceReport>& reports, Report& page) {
  writeText(page.dir() / "frames.csv", framesCsv(reports));
  writeText(page.dir() / "variance.csv", sharesCsv(reports));
  for (const SequenceReport& report : reports) {
    page.add(reportItem("heading", report.name));
    for (const Table& table : tables(report)) page.add(table);
    if (report.evaluations.front().score.frames > 0)
      page.add(reportItem("outliers", "frames.csv", {{"sequence", report.name}}));
    if (report.variances())
      page.add(reportItem("variance", "variance.csv", {{"sequence", report.name}}));
    for (const YAML::Node& frame : report.frames) page.add(frame);
  }
}

}  // namespace predictive_stereo
