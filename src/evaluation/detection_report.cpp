#include "evaluation/detection_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <utility>

#include "predictive_stereo/detectable_speed.h"

namespace predictive_stereo {
namespace {

using Groups = std::vector<std::pair<std::string, DetectionCounts>>;

Groups groupsOf(const DetectionScore& score) {
  Groups groups = {{"all", score.all()}};
  groups.insert(groups.end(), score.byMotion().begin(), score.byMotion().end());
  groups.insert(groups.end(), score.byDistance().begin(), score.byDistance().end());
  return groups;
}

// False boxes have no direction of motion.
bool countsFalseBoxes(const DetectionScore& score, const std::string& group) {
  return score.byMotion().count(group) == 0;
}

std::string titleOf(const std::string& name, const DetectionScore& score) {
  return name + ": " + std::to_string(score.frames()) + " frames, " +
         fixed(score.falsePerFrame(), 3) + " false boxes per frame, " +
         std::to_string(score.idSwitches()) + " id switches";
}

void addLines(const std::string& name, const DetectionScore& score, std::ostream& out) {
  for (const auto& [group, counts] : groupsOf(score)) {
    const bool falses = countsFalseBoxes(score, group);
    const auto cell = [](double value) { return std::isfinite(value) ? fixed(value, 4) : ""; };
    out << name << ',' << group << ',' << score.frames() << ',' << counts.demanded << ','
        << counts.found << ',' << (falses ? std::to_string(counts.false_boxes) : "") << ','
        << cell(counts.recall()) << ',' << (falses ? cell(counts.precision()) : "") << ','
        << (falses ? cell(double(counts.false_boxes) / std::max(1, score.frames())) : "") << ','
        << cell(counts.meanIou()) << ',' << cell(median(counts.distance_errors_m)) << ','
        << cell(median(counts.speed_errors_mps)) << ','
        << (group == "all" ? std::to_string(score.idSwitches()) : "") << '\n';
  }
}

const char* nameOf(FrameVerdict::Box verdict) {
  switch (verdict) {
    case FrameVerdict::kRight:
      return "right";
    case FrameVerdict::kTolerated:
      return "tolerated";
    case FrameVerdict::kFalse:
      return "false";
  }
  return "";
}

const char* labelOutcome(const EvaluatedFrame& frame, size_t label) {
  if (frame.verdict.demanded[label]) return frame.verdict.found_by[label] < 0 ? "missed" : "found";
  return frame.labels[label].isStatic() ? "static" : "tolerated";
}

std::string boxCells(const cv::Rect2d& box) {
  char text[96];
  std::snprintf(text, sizeof(text), "%g,%g,%g,%g", box.x, box.y, box.br().x, box.br().y);
  return text;
}

Table tableOf(const std::string& title, const DetectionScore& score) {
  Table table;
  table.title = title;
  table.header = {"",    "demanded",         "found",          "false", "recall", "precision",
                  "IoU", "distance error m", "speed error m/s"};
  for (const auto& [group, counts] : groupsOf(score)) {
    const bool falses = countsFalseBoxes(score, group);
    table.rows.push_back({group, std::to_string(counts.demanded), std::to_string(counts.found),
                          falses ? std::to_string(counts.false_boxes) : "-",
                          fixed(counts.recall(), 3), falses ? fixed(counts.precision(), 3) : "-",
                          fixed(counts.meanIou(), 2), fixed(median(counts.distance_errors_m), 2),
                          fixed(median(counts.speed_errors_mps), 2)});
  }
  return table;
}

// Recall and precision at IoU 0.3 and 0.5, false boxes per frame.
using Rates = std::array<double, 5>;
const std::vector<std::string> kRateNames = {"recall", "precision", "recall 0.5", "precision 0.5",
                                             "false / frame"};

Rates ratesOf(const std::vector<DetectionEvaluation>& evaluations) {
  DetectionScoreParams strict;
  strict.min_iou = 0.5;
  const DetectionScore score = scoreOf(evaluations), strict_score = scoreOf(evaluations, strict);
  return {score.all().recall(), score.all().precision(), strict_score.all().recall(),
          strict_score.all().precision(), score.falsePerFrame()};
}

std::vector<std::string> cells(const Rates& rates) {
  std::vector<std::string> cells;
  for (double rate : rates) cells.push_back(fixed(rate, 3));
  return cells;
}

std::vector<std::string> row(std::vector<std::string> first, const std::vector<std::string>& rest) {
  first.insert(first.end(), rest.begin(), rest.end());
  return first;
}

// "mean +- standard deviation" of each rate over the runs in which it is defined.
std::vector<std::string> meansAndSpreads(const std::vector<Rates>& runs) {
  std::vector<std::string> cells;
  for (size_t r = 0; r < kRateNames.size(); ++r) {
    double sum = 0, squares = 0, count = 0;
    for (const Rates& rates : runs) {
      if (!std::isfinite(rates[r])) continue;
      sum += rates[r];
      squares += rates[r] * rates[r];
      ++count;
    }
    const double mean = sum / count;
    cells.push_back(count > 0
                        ? fixed(mean, 3) + " +- " +
                              fixed(std::sqrt(std::max(0.0, squares / count - mean * mean)), 3)
                        : "-");
  }
  return cells;
}

}  // namespace

Table pooledTable(const std::vector<DetectionEvaluation>& evaluations) {
  Table table;
  table.title = "recall and precision at IoU 0.3 and 0.5";
  table.header = row({"", "frames", "demanded"}, row(kRateNames, {"ms"}));
  const auto add = [&](const std::string& name, const std::vector<DetectionEvaluation>& some,
                       double ms) {
    const DetectionScore score = scoreOf(some);
    table.rows.push_back(
        row({name, std::to_string(score.frames()), std::to_string(score.all().demanded)},
            row(cells(ratesOf(some)), {ms > 0 ? fixed(ms, 1) : "-"})));
  };
  std::vector<double> times_ms;
  for (const DetectionEvaluation& evaluation : evaluations) {
    add(evaluation.name, {evaluation}, evaluation.median_ms);
    times_ms.push_back(evaluation.median_ms);
  }
  if (evaluations.size() > 1) add("all", evaluations, median(times_ms));
  return table;
}

Table reliabilityTable(const std::vector<DetectionEvaluation>& evaluations) {
  const std::vector<double> limits = {0, 0.5, 0.7, 0.8, 0.9, 0.95, 0.98, 1.0000001};
  struct Bin {
    int boxes = 0, right = 0;
    double sum = 0;
  };
  std::vector<Bin> bins(limits.size() - 1);
  for (const DetectionEvaluation& evaluation : evaluations)
    for (const EvaluatedFrame& frame : evaluation.frames)
      for (size_t o = 0; o < frame.objects.size(); ++o) {
        if (frame.verdict.boxes[o] == FrameVerdict::kTolerated) continue;
        const double score = frame.objects[o].score;
        size_t b = 0;
        while (b + 1 < bins.size() && score >= limits[b + 1]) ++b;
        ++bins[b].boxes;
        bins[b].right += frame.verdict.boxes[o] == FrameVerdict::kRight;
        bins[b].sum += score;
      }
  Table table;
  table.title = "reliability of scores";
  table.header = {"score", "boxes", "mean score", "share right"};
  for (size_t b = 0; b < bins.size(); ++b)
    table.rows.push_back({fixed(limits[b], 2) + " to " + fixed(limits[b + 1], 2),
                          std::to_string(bins[b].boxes), fixed(bins[b].sum / bins[b].boxes, 2),
                          fixed(double(bins[b].right) / bins[b].boxes, 2)});
  return table;
}

Table perturbationTable(const std::vector<PerturbedEvaluation>& runs) {
  Table table;
  table.title = "all sequences under perturbations";
  table.header = row({"", "demanded"}, kRateNames);
  std::vector<Rates> rates;
  for (const PerturbedEvaluation& run : runs) {
    rates.push_back(ratesOf(run.evaluations));
    const int demanded = scoreOf(run.evaluations).all().demanded;
    table.rows.push_back(row({run.perturbation, std::to_string(demanded)}, cells(rates.back())));
  }
  table.rows.push_back(row({"mean +- spread", ""}, meansAndSpreads(rates)));
  return table;
}

Table spreadTable(const std::vector<PerturbedEvaluation>& runs) {
  Table table;
  table.title = "each sequence over perturbations, mean +- spread";
  table.header = row({""}, kRateNames);
  for (size_t s = 0; !runs.empty() && s < runs[0].evaluations.size(); ++s) {
    std::vector<Rates> rates;
    for (const PerturbedEvaluation& run : runs) rates.push_back(ratesOf({run.evaluations[s]}));
    table.rows.push_back(row({runs[0].evaluations[s].name}, meansAndSpreads(rates)));
  }
  return table;
}

Table scoreTable(const DetectionEvaluation& evaluation) {
  std::string name = evaluation.name;
  if (evaluation.median_ms > 0)
    name += " (detection " + fixed(evaluation.median_ms, 1) + " ms, median)";
  return tableOf(titleOf(name, evaluation.score), evaluation.score);
}

Table scoreTable(const std::vector<DetectionEvaluation>& evaluations) {
  const DetectionScore score = scoreOf(evaluations);
  return tableOf(titleOf("all sequences", score), score);
}

Table limitsTable(const Sequence& sequence, const PipelineParams& params) {
  const int last = sequence.frames() - 1;
  const double interval_s = last > 0 ? (sequence.stamp_s(last) - sequence.stamp_s(0)) / last : 0.1;
  const StereoRig& rig = sequence.rig();
  Table table;
  table.title = sequence.name() + ": slowest detectable speeds [m/s], fx " + fixed(rig.fx_px, 0) +
                " px, baseline " + fixed(rig.baseline_m, 3) + " m, " + fixed(1 / interval_s, 1) +
                " frames per second";
  table.header = {"distance"};
  table.rows = {{"across the line of sight"}, {"along it"}};
  for (int depth_m : {5, 10, 15, 20, 30, 40, 60}) {
    const DetectableSpeed slowest = detectableSpeed(
        rig, depth_m, interval_s, params.detection.motion, params.disparity.variance);
    table.header.push_back(std::to_string(depth_m) + " m");
    table.rows[0].push_back(fixed(slowest.across_mps, 1));
    table.rows[1].push_back(fixed(slowest.along_mps, 1));
  }
  return table;
}

std::string csv(const std::vector<DetectionEvaluation>& evaluations) {
  std::ostringstream out;
  out << "sequence,group,frames,demanded,found,false_boxes,recall,precision,false_boxes_per_frame,"
         "mean_iou,median_distance_error_m,median_speed_error_mps,id_switches\n";
  for (const DetectionEvaluation& evaluation : evaluations)
    addLines(evaluation.name, evaluation.score, out);
  if (evaluations.size() > 1) addLines("all", scoreOf(evaluations), out);
  return out.str();
}

std::string framesCsv(const std::vector<DetectionEvaluation>& evaluations) {
  std::ostringstream out;
  out << "sequence,frame,what,id,class,x1,y1,x2,y2,distance_m,speed_mps,motion,score,age,verdict,"
         "found_by\n";
  for (const DetectionEvaluation& evaluation : evaluations)
    for (const EvaluatedFrame& frame : evaluation.frames) {
      for (size_t l = 0; l < frame.labels.size(); ++l) {
        const ObjectLabel& label = frame.labels[l];
        const int by = frame.verdict.found_by[l];
        out << evaluation.name << ',' << frame.index << ",label," << label.track << ','
            << label.type << ',' << boxCells(label.box_px) << ','
            << (label.distance_m ? fixed(*label.distance_m, 2) : "") << ','
            << (label.speed_mps ? fixed(*label.speed_mps, 2) : "") << ',' << label.motion << ",,,"
            << labelOutcome(frame, l) << ','
            << (by < 0 ? "" : std::to_string(frame.objects[static_cast<size_t>(by)].id)) << '\n';
      }
      for (size_t o = 0; o < frame.objects.size(); ++o) {
        const DetectedObject& object = frame.objects[o];
        out << evaluation.name << ',' << frame.index << ",object," << object.id << ",,"
            << boxCells(object.box_px) << ',' << fixed(object.distance_m, 2) << ','
            << fixed(object.velocity_mps.norm(), 2) << ",," << fixed(object.score, 2) << ','
            << object.age << ',' << nameOf(frame.verdict.boxes[o]) << ",\n";
      }
    }
  return out.str();
}

cv::Mat3b picture(const cv::Mat1b& left, const EvaluatedFrame& frame) {
  cv::Mat3b image;
  cv::cvtColor(left, image, cv::COLOR_GRAY2BGR);
  const auto write = [&](const std::string& text, cv::Point at, const cv::Scalar& colour) {
    at.y = std::max(at.y, 10);
    cv::putText(image, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.4, {0, 0, 0}, 3, cv::LINE_AA);
    cv::putText(image, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.4, colour, 1, cv::LINE_AA);
  };
  for (size_t o = 0; o < frame.objects.size(); ++o) {
    static const cv::Scalar colours[] = {{0, 200, 0}, {0, 220, 255}, {0, 0, 255}};
    const cv::Scalar& colour = colours[frame.verdict.boxes[o]];
    const DetectedObject& object = frame.objects[o];
    cv::rectangle(image, cv::Rect(object.box_px), colour, 2);
    write(std::to_string(object.id) + ": " + fixed(object.distance_m, 1) + " m, " +
              fixed(object.velocity_mps.norm(), 1) + " m/s",
          cv::Point(object.box_px.tl()) - cv::Point(0, 4), colour);
  }
  for (size_t l = 0; l < frame.labels.size(); ++l) {
    const ObjectLabel& label = frame.labels[l];
    const std::string fate = labelOutcome(frame, l);
    cv::Scalar colour(150, 150, 150);
    if (fate == "found") colour = {255, 255, 255};
    if (fate == "missed") colour = {255, 0, 255};
    if (fate == "static") colour = {255, 120, 0};
    cv::rectangle(image, cv::Rect(label.box_px), colour, 1);
    if (fate == "missed")
      write(label.type + " " + std::to_string(label.track) + ", " + label.motion,
            cv::Point(static_cast<int>(label.box_px.x), static_cast<int>(label.box_px.br().y) + 12),
            colour);
  }
  return image;
}

void add(const std::vector<DetectionEvaluation>& evaluations, const std::vector<Table>& limits,
         Report& page) {
  page.addText(
      "A box is correct if its IoU with a demanded object is 0.3 or more. An object is demanded "
      "from the third frame on in which it is visible. Errors are medians of absolute values; "
      "speed errors are of objects up to 25 m away. Labels are thin (demanded white, missed "
      "magenta, tolerated grey, parked blue), detected boxes thick (correct green, tolerated "
      "yellow, false red).");
  for (const DetectionEvaluation& evaluation : evaluations) page.add(scoreTable(evaluation));
  if (evaluations.size() > 1) page.add(scoreTable(evaluations));
  for (const Table& table : limits) page.add(table);
}

}  // namespace predictive_stereo
