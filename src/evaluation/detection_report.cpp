#include "evaluation/detection_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "evaluation/statistics.h"
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

// The figures of a group. False boxes have no direction of motion.
// @param per_frame  also false boxes per frame. @param missing  for figures without a value.
Row figuresOf(const DetectionScore& score, const std::string& group, const DetectionCounts& counts,
              int rate_decimals, int decimals, bool per_frame, const char* missing) {
  const bool falses = score.byMotion().count(group) == 0;
  const double false_boxes = falses ? counts.false_boxes : kNotKnown;
  const auto rate = [&](double value) { return fixed(value, rate_decimals, missing); };
  const auto mean = [&](double value) { return fixed(value, decimals, missing); };
  return row(counts.demanded, counts.found, fixed(false_boxes, 0, missing), rate(counts.recall()),
             rate(falses ? counts.precision() : kNotKnown),
             per_frame ? row(rate(false_boxes / std::max(1, score.frames()))) : Row(),
             mean(counts.meanIou()), mean(median(counts.distance_errors_m)),
             mean(median(counts.speed_errors_mps)));
}

void addLines(const std::string& name, const DetectionScore& score, Table& csv) {
  for (const auto& [group, counts] : groupsOf(score))
    csv.add(name, group, score.frames(), figuresOf(score, group, counts, 4, 4, true, ""),
            group == "all" ? std::to_string(score.idSwitches()) : "");
}

const char* labelOutcome(const EvaluatedFrame& frame, size_t label) {
  if (frame.verdict.demanded[label]) return frame.verdict.found_by[label] < 0 ? "missed" : "found";
  return frame.labels[label].isStatic() ? "static" : "tolerated";
}

Table tableOf(const std::string& name, const DetectionScore& score) {
  Table table{name + ": " + std::to_string(score.frames()) + " frames, " +
                  fixed(score.falsePerFrame(), 3) + " false boxes per frame, " +
                  std::to_string(score.idSwitches()) + " id switches",
              {"", "demanded", "found", "false", "recall", "precision", "IoU", "distance error m",
               "speed error m/s"}};
  for (const auto& [group, counts] : groupsOf(score))
    table.add(group, figuresOf(score, group, counts, 3, 2, false, "-"));
  return table;
}

// Recall and precision at IoU 0.3 and 0.5, false boxes per frame.
using Rates = std::array<double, 5>;
const Row kRateNames = {"recall", "precision", "recall 0.5", "precision 0.5", "false / frame"};

Rates ratesOf(const std::vector<DetectionEvaluation>& evaluations) {
  DetectionScoreParams strict;
  strict.min_iou = 0.5;
  const DetectionScore score = scoreOf(evaluations), strict_score = scoreOf(evaluations, strict);
  return {score.all().recall(), score.all().precision(), strict_score.all().recall(),
          strict_score.all().precision(), score.falsePerFrame()};
}

Row cells(const Rates& rates) {
  Row cells;
  for (double rate : rates) cells.push_back(fixed(rate, 3));
  return cells;
}

// "mean +- standard deviation" of each rate over the runs in which it is defined.
Row meansAndSpreads(const std::vector<Rates>& runs) {
  Row cells;
  for (size_t r = 0; r < kRateNames.size(); ++r) {
    Moments moments;
    for (const Rates& rates : runs)
      if (std::isfinite(rates[r])) moments.add(rates[r]);
    cells.push_back(moments.count() ? fixed(moments.mean(), 3) + " +- " +
                                          fixed(std::sqrt(std::max(0.0, moments.variance())), 3)
                                    : "-");
  }
  return cells;
}

}  // namespace

Table pooledTable(const std::vector<DetectionEvaluation>& evaluations) {
  Table table{"recall and precision at IoU 0.3 and 0.5",
              row("", "frames", "demanded", kRateNames, "ms")};
  const auto add = [&](const std::string& name, const std::vector<DetectionEvaluation>& some,
                       double ms) {
    const DetectionScore score = scoreOf(some);
    table.add(name, score.frames(), score.all().demanded, cells(ratesOf(some)),
              ms > 0 ? fixed(ms, 1) : "-");
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
    Moments scores, right;
  };
  std::vector<Bin> bins(limits.size() - 1);
  for (const DetectionEvaluation& evaluation : evaluations)
    for (const EvaluatedFrame& frame : evaluation.frames)
      for (size_t o = 0; o < frame.objects.size(); ++o) {
        if (frame.verdict.boxes[o] == FrameVerdict::kTolerated) continue;
        const double score = frame.objects[o].score;
        size_t b = 0;
        while (b + 1 < bins.size() && score >= limits[b + 1]) ++b;
        bins[b].scores.add(score);
        bins[b].right.add(frame.verdict.boxes[o] == FrameVerdict::kRight);
      }
  Table table{"reliability of scores", {"score", "boxes", "mean score", "share right"}};
  for (size_t b = 0; b < bins.size(); ++b) {
    const auto& [scores, right] = bins[b];
    const auto mean = [](const Moments& of) { return of.count() ? fixed(of.mean(), 2) : "-"; };
    table.add(fixed(limits[b], 2) + " to " + fixed(limits[b + 1], 2), scores.count(), mean(scores),
              mean(right));
  }
  return table;
}

Table perturbationTable(const std::vector<PerturbedEvaluation>& runs) {
  Table table{"all sequences under perturbations", row("", "demanded", kRateNames)};
  std::vector<Rates> rates;
  for (const PerturbedEvaluation& run : runs) {
    rates.push_back(ratesOf(run.evaluations));
    table.add(run.perturbation, scoreOf(run.evaluations).all().demanded, cells(rates.back()));
  }
  table.add("mean +- spread", "", meansAndSpreads(rates));
  return table;
}

std::vector<Table> scoreTables(const std::vector<DetectionEvaluation>& evaluations) {
  std::vector<Table> tables;
  for (const DetectionEvaluation& evaluation : evaluations) {
    const double ms = evaluation.median_ms;
    tables.push_back(
        tableOf(evaluation.name + (ms > 0 ? " (detection " + fixed(ms, 1) + " ms, median)" : ""),
                evaluation.score));
  }
  if (evaluations.size() > 1) tables.push_back(tableOf("all sequences", scoreOf(evaluations)));
  return tables;
}

Table limitsTable(const Sequence& sequence, const PipelineParams& params) {
  const int last = sequence.frames() - 1;
  const double interval_s = last > 0 ? (sequence.stamp_s(last) - sequence.stamp_s(0)) / last : 0.1;
  const StereoRig& rig = sequence.rig();
  Table table{sequence.name() + ": slowest detectable speeds [m/s], fx " + fixed(rig.fx_px, 0) +
                  " px, baseline " + fixed(rig.baseline_m, 3) + " m, " + fixed(1 / interval_s, 1) +
                  " frames per second",
              {"distance"},
              {{"across the line of sight"}, {"along it"}}};
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
  Table csv = Table::ofCsv(
      "sequence,group,frames,demanded,found,false_boxes,recall,precision,false_boxes_per_frame,"
      "mean_iou,median_distance_error_m,median_speed_error_mps,id_switches");
  for (const DetectionEvaluation& evaluation : evaluations)
    addLines(evaluation.name, evaluation.score, csv);
  if (evaluations.size() > 1) addLines("all", scoreOf(evaluations), csv);
  return csv.csv();
}

std::string framesCsv(const std::vector<DetectionEvaluation>& evaluations) {
  Table csv = Table::ofCsv(
      "sequence,frame,what,id,class,x1,y1,x2,y2,distance_m,speed_mps,motion,score,age,verdict,"
      "found_by");
  const auto start = [&](const std::string& name, int frame, const char* what, int id,
                         const std::string& type, const cv::Rect2d& box) {
    return row(name, frame, what, id, type, box.x, box.y, box.br().x, box.br().y);
  };
  const auto known = [](const std::optional<double>& value) {
    return value ? fixed(*value, 2) : "";
  };
  static const char* const verdicts[] = {"right", "tolerated", "false"};  // of FrameVerdict::Box
  for (const DetectionEvaluation& evaluation : evaluations)
    for (const EvaluatedFrame& frame : evaluation.frames) {
      for (size_t l = 0; l < frame.labels.size(); ++l) {
        const ObjectLabel& label = frame.labels[l];
        const int by = frame.verdict.found_by[l];
        csv.add(start(evaluation.name, frame.index, "label", label.track, label.type, label.box_px),
                known(label.distance_m), known(label.speed_mps), label.motion, "", "",
                labelOutcome(frame, l),
                by < 0 ? "" : std::to_string(frame.objects[static_cast<size_t>(by)].id));
      }
      for (size_t o = 0; o < frame.objects.size(); ++o) {
        const DetectedObject& object = frame.objects[o];
        csv.add(start(evaluation.name, frame.index, "object", object.id, "", object.box_px),
                known(object.distance_m), known(object.velocity_mps.norm()), "",
                fixed(object.score, 2), object.age, verdicts[frame.verdict.boxes[o]]);
      }
    }
  return csv.csv();
}

}  // namespace predictive_stereo
