/// Detected moving objects against labels: scores of frames and of whole sequences.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "evaluation/object_labels.h"
#include "evaluation/sequence.h"
#include "predictive_stereo/pipeline.h"

namespace predictive_stereo {

struct DetectionScoreParams {
  double min_iou = 0.3;          ///< of a match
  int first_visible_frame = 3;   ///< an object is demanded from this visible frame on
  double tolerated_share = 0.5;  ///< a box with this share on tolerated objects is tolerated
};

/// Counts of some group of objects.
struct DetectionCounts {
  int demanded = 0;
  int found = 0;
  int false_boxes = 0;
  double sum_iou = 0;
  std::vector<double> distance_errors_m, speed_errors_mps;  ///< absolute, of matches

  double recall() const;     ///< NaN if nothing is demanded
  double precision() const;  ///< NaN without boxes that count
  double meanIou() const;    ///< NaN without matches
};

/// Outcome of one frame.
struct FrameVerdict {
  enum Box { kRight, kTolerated, kFalse };
  std::vector<Box> boxes;      ///< of each detected object
  std::vector<bool> demanded;  ///< of each label
  std::vector<int> found_by;   ///< of each label: the object that found it, or -1
};

/// Demanded objects and boxes are matched one to one, the best IoU first. A second box on an object
/// is false, and so is a box on a parked ("static") object. Boxes on tolerated objects count
/// neither as correct nor as false.
class DetectionScore {
 public:
  /// Speeds are compared up to this distance.
  static constexpr double kSpeedScored_m = 25;

  explicit DetectionScore(const DetectionScoreParams& params = {}) : params_(params) {}

  /// Adds the next frame.
  FrameVerdict add(const std::vector<ObjectLabel>& labels,
                   const std::vector<DetectedObject>& objects);
  /// Starts another sequence: its tracks and ids are unrelated to the previous ones.
  void startSequence();

  int frames() const { return frames_; }
  /// How often a labelled object is found with another id than the last time.
  int idSwitches() const { return id_switches_; }
  /// NaN without frames.
  double falsePerFrame() const;
  const DetectionCounts& all() const { return all_; }
  /// By direction of motion: toward, away, crossing, ...; without false boxes.
  const std::map<std::string, DetectionCounts>& byMotion() const { return by_motion_; }
  /// By distance; false boxes by their own distance.
  const std::map<std::string, DetectionCounts>& byDistance() const { return by_distance_; }

 private:
  struct Visibility {
    int last_frame = 0, frames = 0;
  };

  bool visibleForLong(int track);

  DetectionScoreParams params_;
  int frames_ = 0, id_switches_ = 0;
  DetectionCounts all_;
  std::map<std::string, DetectionCounts> by_motion_, by_distance_;
  std::map<int, Visibility> visibility_;  // by track
  std::map<int, int> last_id_;            // by track
};

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

/// @param max_frames  0: all.
/// @param seen  called after each frame; may be empty.
/// @throws std::runtime_error if there are no labels of moving objects.
DetectionEvaluation evaluateDetection(
    const Sequence& sequence, const Detector& detector, int max_frames,
    const std::function<void(const EvaluatedFrame&, const SequenceFrame&)>& seen);

/// The score of all sequences together.
DetectionScore scoreOf(const std::vector<DetectionEvaluation>& evaluations,
                       const DetectionScoreParams& params = {});

}  // namespace predictive_stereo
