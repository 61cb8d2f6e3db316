#include "predictive_stereo/moving_objects.h"

#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>

#include "detection/motion_noise.h"
#include "detection/motion_scheme.h"
#include "detection/paper_windows.h"
#include "detection/rescaling.h"
#include "detection/tracker.h"
#include "imaging/size_check.h"
#include "predictive_stereo/path_covariance.h"
#include "predictive_stereo/residual.h"

namespace predictive_stereo {
namespace {

std::string text(cv::Size size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

void requireSizes(const DetectionInput& input, DetectionScheme scheme) {
  if (input.rig.size.empty())
    throw std::invalid_argument(
        "rig.size = 0x0: set the calibration of the images (StereoRig::fromProjections)");
  requireSize("left image", input.left.size(), input.rig.size);
  requireSize("measured disparity", input.measured_disparity_px.size(), input.rig.size);
  requireSize("measured variance", input.measured_variance_px2.size(), input.rig.size);
  if (scheme != DetectionScheme::kPaper) return;
  requireSize("predicted disparity", input.predicted_disparity_px.size(), input.rig.size);
  requireSize("predicted variance", input.predicted_variance_px2.size(), input.rig.size);
}

// With bounds that exclude each other no object would ever be plausible.
void requireOrder(const char* least_name, double least_m, const char* most_name, double most_m) {
  if (least_m <= most_m) return;
  std::ostringstream text;
  text << least_name << " = " << least_m << ": must not be above " << most_name << " = " << most_m;
  throw std::invalid_argument(text.str());
}

void validateDetection(const DetectionParams& params) {
  validate(params);
  validate(params.range, "range/");
  const PaperDetectionParams& paper = params.paper;
  const cv::Size smallest(paper.smallest_window_width_px, paper.smallest_window_height_px);
  const cv::Size largest(paper.largest_window_width_px, paper.largest_window_height_px);
  if (largest.width < smallest.width || largest.height < smallest.height)
    throw std::invalid_argument("paper/largest_window = " + text(largest) +
                                " px: must not be below paper/smallest_window = " + text(smallest) +
                                " px");
  const MotionDetectionParams& motion = params.motion;
  requireOrder("motion/min_height_m", motion.min_height_m, "motion/max_height_m",
               motion.max_height_m);
  requireOrder("motion/min_width_m", motion.min_width_m, "motion/max_width_m", motion.max_width_m);
}

TrackingParams trackingOf(const DetectionParams& params) {
  TrackingParams tracking = params.tracking;
  if (params.scheme == DetectionScheme::kPaper) {
    tracking.confirm_frames = 1;
    tracking.confirm_evidence = -std::numeric_limits<double>::infinity();
    tracking.max_missed_frames = 0;
  }
  return tracking;
}

// The objects of a frame by the paper's scheme.
std::vector<Observation> observeAsPaper(const DetectionInput& input,
                                        const DetectionParams& params) {
  constexpr float kMovingPx = 1.0f;
  cv::Mat1f difference_px;
  absoluteDifference(input.measured_disparity_px, input.predicted_disparity_px, params.range,
                     static_cast<float>(params.paper.max_difference_px), difference_px);
  std::vector<Observation> observed;
  for (const cv::Rect& box : movingBoxes(difference_px, params.paper)) {
    Observation seen;
    seen.box_px = box;
    seen.mask = difference_px(box) >= kMovingPx;
    if (!measureShape(input, params.range, seen)) continue;
    seen.centre_covariance = Eigen::Vector3d(0.25, 0.25, 1.0).asDiagonal();
    seen.score = cv::mean(seen.mask)[0] / 255;
    observed.push_back(std::move(seen));
  }
  return observed;
}

// Whether an object that is not seen in this frame was seen in the three before. It may then be
// missing, as when it was occluded in the previous frame.
bool wasSteadilySeen(const ObjectTrack& track) {
  constexpr unsigned kThreeFrames = 0b111;
  const bool missed = (track.history & 1) == 0;  // otherwise it was not sought
  return track.unseen_frames == 1 &&
         (track.history >> (missed ? 1 : 0) & kThreeFrames) == kThreeFrames;
}

}  // namespace

struct MovingObjectDetector::State {
  DetectionParams params;
  ObjectTracker tracker;
  MotionScheme motion;
  Rescaling rescaling;
  // Of the rescaled images.
  DisparityRange range;
  StereoRig rig;
  DetectionInput rescaled;
  Detections rescaled_detections;
  std::vector<Observation> observed;
  // Of the last frame, also if it showed an image again; the motion since another image was shown.
  Eigen::Isometry3d T_odom_last = Eigen::Isometry3d::Identity();
  PathCovariance motion_since_image;

  explicit State(const DetectionParams& p)
      : params(p),
        tracker(trackingOf(p), p.motion.largest_speed_mps),
        motion(p.range, p.motion),
        range(p.range) {}

  void reset() {
    tracker.reset();
    motion.reset();
  }
  void setRig(const StereoRig& camera);
  const DetectionInput& rescaledOf(const DetectionInput& input) {
    if (rescaling.isNone()) return input;
    rescaling.rescale(input, params.range, rescaled);
    return rescaled;
  }
  void continueMotion(DetectionInput& input);
  void find(const DetectionInput& input);
  void report(const DetectionInput& input, Detections& detections) const;
};

// Another column correction changes all disparities by a constant: the past is corrected by it. Any
// other change of the rig resets the detector.
void MovingObjectDetector::State::setRig(const StereoRig& camera) {
  // The paper's scheme gets the camera's images.
  if (params.scheme != DetectionScheme::kPaper && !rescaling.isOf(camera)) {
    rescaling = Rescaling(camera);
    range = rescaling.of(params.range);
    motion = MotionScheme(range, params.motion);
  }
  const StereoRig new_rig = rescaling.of(camera);
  StereoRig other_columns = rig;
  other_columns.cx_right_px = new_rig.cx_right_px;
  if (other_columns != new_rig)
    reset();
  else if (rig != new_rig)
    motion.addToDisparities(new_rig.cx_right_px - rig.cx_right_px);
  rig = new_rig;
}

// The covariance becomes that of the motion since the last frame that find() has seen.
void MovingObjectDetector::State::continueMotion(DetectionInput& input) {
  if (input.pose_state != PoseState::kKnown) return;
  motion_since_image.add(
      {relative(input.T_odom_cam, T_odom_last), toldCovariance(input.motion_covariance)},
      CommonErrors::Zero());
  T_odom_last = input.T_odom_cam;
  input.motion_covariance = motion_since_image.covariance();
}

void MovingObjectDetector::State::find(const DetectionInput& input) {
  tracker.predict(
      input.stamp_s, input.rig,
      input.pose_state == PoseState::kKnown ? std::optional(input.T_odom_cam) : std::nullopt);
  const bool by_paper = params.scheme == DetectionScheme::kPaper;
  motion_since_image = PathCovariance();
  observed = by_paper ? observeAsPaper(input, params)
                      : motion.observe(input, rescaling.cameraPixel_px(), tracker);
  tracker.update(observed, by_paper || motion.soughtKnown());
}

// The objects of all confirmed tracks that are in the image.
void MovingObjectDetector::State::report(const DetectionInput& input,
                                         Detections& detections) const {
  detections.objects.clear();
  detections.mask.create(input.rig.size);
  detections.mask.setTo(0);
  const cv::Rect image(cv::Point(), input.rig.size);
  cv::Mat1b unseen_mask;
  for (const ObjectTrack& track : tracker.tracks()) {
    if (!track.confirmed) continue;
    if (track.observation >= 0) {
      const Observation& object = observed[static_cast<size_t>(track.observation)];
      detections.mask(object.box_px).setTo(255, object.mask);
    } else if (wasSteadilySeen(track) &&
               isStillThere(input, range, track.last, params.motion.layer_margin_m, unseen_mask)) {
      detections.mask(track.last.box_px & image).setTo(255, unseen_mask);
    } else {
      continue;
    }
    detections.objects.push_back(tracker.describe(track));
  }
}

MovingObjectDetector::MovingObjectDetector(const DetectionParams& params) {
  validateDetection(params);
  state_ = std::make_unique<State>(params);
}
MovingObjectDetector::~MovingObjectDetector() = default;
MovingObjectDetector::MovingObjectDetector(MovingObjectDetector&&) noexcept = default;
MovingObjectDetector& MovingObjectDetector::operator=(MovingObjectDetector&&) noexcept = default;

void MovingObjectDetector::detect(const DetectionInput& given, Detections& detections) {
  State& state = *state_;
  requireSizes(given, state.params.scheme);
  state.setRig(given.rig);
  DetectionInput input = state.rescaledOf(given);
  state.continueMotion(input);
  // An image that is shown again has the objects that it had.
  if (!state.motion.isShownAgain(input)) state.find(input);

  if (state.rescaling.isNone()) return state.report(input, detections);
  state.report(input, state.rescaled_detections);
  state.rescaling.restore(state.rescaled_detections, detections);
}

void MovingObjectDetector::setParams(const DetectionParams& params) {
  MovingObjectDetector changed(params);
  State& state = *state_;
  if (params.range != state.params.range || params.scheme != state.params.scheme) {
    changed.state_->tracker.continueIds(state.tracker);
    state_ = std::move(changed.state_);
    return;
  }
  state.params = params;
  state.tracker.setParams(trackingOf(params), params.motion.largest_speed_mps);
  state.motion.setParams(params.motion);
}

void MovingObjectDetector::reset() { state_->reset(); }

}  // namespace predictive_stereo
