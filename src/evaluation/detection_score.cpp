#include "evaluation/detection_score.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <tuple>

#include "evaluation/statistics.h"
#include "tools/progress.h"

namespace predictive_stereo {
namespace {

double intersectionOverUnion(const cv::Rect2d& a, const cv::Rect2d& b) {
  const double both = (a & b).area();
  return both / std::max(a.area() + b.area() - both, 1e-9);
}

std::string distanceGroup(const std::optional<double>& distance_m) {
  if (!distance_m) return "unknown";
  if (*distance_m < 15) return "0-15 m";
  if (*distance_m < 25) return "15-25 m";
  if (*distance_m < 35) return "25-35 m";
  return "35 m and more";
}

// Matches demanded objects and boxes one to one, the best pair first.
void matchBoxes(const std::vector<ObjectLabel>& labels, const std::vector<DetectedObject>& objects,
                double min_iou, FrameVerdict& verdict) {
  std::vector<std::tuple<double, size_t, size_t>> pairs;
  for (size_t l = 0; l < labels.size(); ++l)
    for (size_t o = 0; o < objects.size(); ++o) {
      const double iou = intersectionOverUnion(labels[l].box_px, objects[o].box_px);
      if (verdict.demanded[l] && iou >= min_iou) pairs.emplace_back(-iou, l, o);
    }
  std::sort(pairs.begin(), pairs.end());
  for (const auto& [negative_iou, l, o] : pairs) {
    if (verdict.found_by[l] >= 0 || verdict.boxes[o] == FrameVerdict::kRight) continue;
    verdict.found_by[l] = static_cast<int>(o);
    verdict.boxes[o] = FrameVerdict::kRight;
  }
}

}  // namespace

double DetectionCounts::recall() const { return ratio(found, demanded, kNotKnown); }
double DetectionCounts::precision() const { return ratio(found, found + false_boxes, kNotKnown); }
double DetectionCounts::meanIou() const { return ratio(sum_iou, found, kNotKnown); }

double DetectionScore::falsePerFrame() const { return ratio(all_.false_boxes, frames_, kNotKnown); }

void DetectionScore::startSequence() {
  visibility_.clear();
  last_id_.clear();
}

// An object that was hidden for a while counts as new.
bool DetectionScore::visibleForLong(int track) {
  Visibility& seen = visibility_[track];
  if (seen.last_frame != frames_)
    seen.frames = seen.last_frame == frames_ - 1 ? seen.frames + 1 : 1;
  seen.last_frame = frames_;
  return seen.frames >= params_.first_visible_frame;
}

FrameVerdict DetectionScore::add(const std::vector<ObjectLabel>& labels,
                                 const std::vector<DetectedObject>& objects) {
  ++frames_;
  FrameVerdict verdict;
  verdict.boxes.assign(objects.size(), FrameVerdict::kFalse);
  verdict.found_by.assign(labels.size(), -1);
  for (const ObjectLabel& label : labels) {
    const bool long_enough = visibleForLong(label.track);
    verdict.demanded.push_back(label.isDemanded() && long_enough);
  }

  matchBoxes(labels, objects, params_.min_iou, verdict);

  for (size_t l = 0; l < labels.size(); ++l) {
    if (!verdict.demanded[l]) continue;
    const ObjectLabel& label = labels[l];
    const DetectedObject* object =
        verdict.found_by[l] < 0 ? nullptr : &objects[static_cast<size_t>(verdict.found_by[l])];
    for (DetectionCounts* counts :
         {&all_, &by_motion_[label.motion], &by_distance_[distanceGroup(label.distance_m)]}) {
      ++counts->demanded;
      if (!object) continue;
      ++counts->found;
      counts->sum_iou += intersectionOverUnion(label.box_px, object->box_px);
      if (label.distance_m)
        counts->distance_errors_m.push_back(std::abs(object->distance_m - *label.distance_m));
      if (label.speed_mps && label.distance_m && *label.distance_m < kSpeedScored_m)
        counts->speed_errors_mps.push_back(
            std::abs(object->velocity_mps.norm() - *label.speed_mps));
    }
    if (!object) continue;
    const auto [known, is_new] = last_id_.emplace(label.track, object->id);
    if (!is_new && known->second != object->id) ++id_switches_;
    known->second = object->id;
  }

  for (size_t o = 0; o < objects.size(); ++o) {
    if (verdict.boxes[o] == FrameVerdict::kRight) continue;
    const cv::Rect2d box = objects[o].box_px;
    double share = 0;
    for (size_t l = 0; l < labels.size(); ++l) {
      if (verdict.demanded[l] || labels[l].isStatic()) continue;
      if (intersectionOverUnion(labels[l].box_px, box) >= params_.min_iou) share = 1;
      share += (labels[l].box_px & box).area() / std::max(box.area(), 1e-9);
    }
    if (share >= params_.tolerated_share) {
      verdict.boxes[o] = FrameVerdict::kTolerated;
    } else {
      ++all_.false_boxes;
      ++by_distance_[distanceGroup(objects[o].distance_m)].false_boxes;
    }
  }
  return verdict;
}

Detector pipelineDetector(const PipelineParams& params) {
  const auto pipeline = std::make_shared<Pipeline>(params);
  const auto output = std::make_shared<PipelineOutput>();
  return [=](const StereoFrame& frame) {
    pipeline->process(frame, *output);
    return DetectorOutput{output->detections.objects, pipeline->times().detection.front().ms};
  };
}

DetectionEvaluation evaluateDetection(
    const Sequence& sequence, const Detector& detector, int max_frames,
    const std::function<void(const EvaluatedFrame&, const SequenceFrame&)>& seen) {
  DetectionEvaluation evaluation;
  evaluation.name = sequence.name();
  const int frames = framesOf(sequence, max_frames);
  std::vector<double> times_ms;
  Progress progress(sequence.name(), frames);
  for (int index = 0; index < frames; ++index) {
    const SequenceFrame images = sequence.frame(index);
    const auto known = sequence.objects(index);
    if (!known)
      throw std::runtime_error(sequence.name() +
                               ": has no labels of moving objects; give --labels");
    const DetectorOutput output = detector(stereoFrame(sequence, index, images));
    EvaluatedFrame frame;
    frame.index = index;
    frame.labels = *known;
    frame.objects = output.objects;
    frame.verdict = evaluation.score.add(frame.labels, frame.objects);
    times_ms.push_back(output.ms);
    if (seen) seen(frame, images);
    evaluation.frames.push_back(std::move(frame));
    progress.update(index);
  }
  evaluation.median_ms = median(times_ms);
  return evaluation;
}

DetectionScore scoreOf(const std::vector<DetectionEvaluation>& evaluations,
                       const DetectionScoreParams& params) {
  DetectionScore score(params);
  for (const DetectionEvaluation& evaluation : evaluations) {
    score.startSequence();
    for (const EvaluatedFrame& frame : evaluation.frames) score.add(frame.labels, frame.objects);
  }
  return score;
}

}  // namespace predictive_stereo
