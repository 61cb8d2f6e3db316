/// How good detected moving objects are, against labels or the synthetic street's truth.
#pragma once

#include <iosfwd>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "predictive_stereo/moving_objects.h"
#include "simulation/street.h"

namespace predictive_stereo {

/// One labelled object in one frame.
struct LabelledObject {
  enum class Kind {
    kDemanded,   ///< to be found
    kTolerated,  ///< a box on it neither counts nor harms
    kStatic,     ///< a box on it is false
  };
  int frame = 0;
  int track = 0;
  std::string class_name;
  cv::Rect2f box_px;
  std::optional<double> distance_m;  ///< depth of its nearest part
  std::string motion;                ///< toward, away, crossing: the group it is counted in
  std::optional<double> speed_mps;   ///< over ground
  Kind kind = Kind::kDemanded;
};
using Labels = std::map<int, std::vector<LabelledObject>>;  ///< by frame

/// Reads `frame,track,class,x1,y1,x2,y2,distance_m,truncated,occluded,motion,hard` with that header
/// line. Class "ignore" and hard = 1 are tolerated, class "static" is static.
/// @throws std::runtime_error that names the file and the line.
Labels readLabels(const std::string& path);

/// What a street's frame demands: movers nearer than 35 m and faster than 2 m/s over ground, of
/// which at least half is visible, in at least 20 x 20 pixels or 400. All other movers are
/// tolerated.
std::vector<LabelledObject> labelsOf(const StreetFrame& frame);

struct DetectionScoreParams {
  double min_iou = 0.3;          ///< of a match
  int first_frame_of_track = 3;  ///< an object is demanded from this frame of its visibility on
  double tolerated_share = 0.5;  ///< a box is tolerated where so much of it lies on tolerated ones
};

/// Counts of some group of objects.
struct DetectionCounts {
  int demanded = 0, found = 0;
  double sum_iou = 0;
  std::vector<double> distance_errors_m, speed_errors_mps;  ///< absolute, of matches

  double recall() const { return demanded ? double(found) / demanded : 0; }
  double meanIou() const { return found ? sum_iou / found : 0; }
};
double median(std::vector<double> values);

class DetectionScore {
 public:
  explicit DetectionScore(const DetectionScoreParams& params = {}) : params_(params) {}

  /// Frames must come in order. The verdict on each object, for pictures: true, false, or none
  /// (tolerated).
  std::vector<std::optional<bool>> add(const std::vector<LabelledObject>& labels,
                                       const std::vector<DetectedObject>& objects);
  /// Another sequence begins: its tracks and ids have nothing to do with those before.
  void startSequence();

  int frames = 0;
  int matched = 0;  ///< boxes on demanded objects
  int false_boxes = 0;
  int id_switches = 0;  ///< a labelled track is found under another id than last time
  DetectionCounts all;
  std::map<std::string, DetectionCounts> by_motion, by_distance;

  double precision() const {
    return matched + false_boxes ? double(matched) / (matched + false_boxes) : 1;
  }
  double falsePerFrame() const { return frames ? double(false_boxes) / frames : 0; }

 private:
  DetectionScoreParams params_;
  std::map<int, int> frames_of_track_;
  std::map<int, int> id_of_track_;
};

/// A table of all figures.
void print(const DetectionScore& score, const std::string& title, std::ostream& out);

}  // namespace predictive_stereo
