/// Evaluation of detections on a whole sequence against its labels.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "evaluation/detection_score.h"
#include "evaluation/sequence.h"
#include "predictive_stereo/pipeline.h"

namespace predictive_stereo {

/// The detections of one frame.
struct DetectorOutput {
  std::vector<DetectedObject> objects;
  double ms = 0;  ///< time of the detection; 0: not known
};
/// A detector, which is called with all frames of a sequence in their order.
using Detector = std::function<DetectorOutput(const StereoFrame& frame)>;

/// The whole pipeline.
Detector pipelineDetector(const PipelineParams& params);

struct EvaluatedFrame {
  int index = 0;
  std::vector<ObjectLabel> labels;
  std::vector<DetectedObject> objects;
  FrameVerdict verdict;
};

struct DetectionEvaluation {
  std::string name;
  DetectionScore score;
  std::vector<EvaluatedFrame> frames;
  double median_ms = 0;  ///< per frame; 0: not known
};

/// @param labels  by Sequence::fileNumber; none: the sequence has ground truth of moving objects.
/// @param max_frames  0: all.
/// @param seen  called after each frame; may be empty.
/// @throws std::runtime_error if there are no labels of moving objects.
DetectionEvaluation evaluateDetection(
    const Sequence& sequence, const std::optional<std::vector<ObjectLabel>>& labels,
    const Detector& detector, int max_frames,
    const std::function<void(const EvaluatedFrame&, const SequenceFrame&)>& seen);

/// The score of all sequences together.
DetectionScore scoreOf(const std::vector<DetectionEvaluation>& evaluations,
                       const DetectionScoreParams& params = {});

}  // namespace predictive_stereo
