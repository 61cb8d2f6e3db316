#include "evaluation/detection_evaluation.h"

#include <memory>
#include <stdexcept>

#include "evaluation/statistics.h"
#include "tools/progress.h"

namespace predictive_stereo {

Detector pipelineDetector(const PipelineParams& params) {
  const auto pipeline = std::make_shared<Pipeline>(params);
  const auto output = std::make_shared<PipelineOutput>();
  return [=](const StereoFrame& frame) {
    pipeline->process(frame, *output);
    return DetectorOutput{output->detections.objects, pipeline->times().detection.front().ms};
  };
}

DetectionEvaluation evaluateDetection(
    const Sequence& sequence, const std::optional<std::vector<ObjectLabel>>& labels,
    const Detector& detector, int max_frames,
    const std::function<void(const EvaluatedFrame&, const SequenceFrame&)>& seen) {
  DetectionEvaluation evaluation;
  evaluation.name = sequence.name();
  const int frames = framesOf(sequence, max_frames);
  std::vector<double> times_ms;
  Progress progress(sequence.name(), frames);
  for (int index = 0; index < frames; ++index) {
    const SequenceFrame images = sequence.frame(index);
    const auto known =
        labels ? labelsOf(*labels, sequence.fileNumber(index)) : sequence.objects(index);
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
