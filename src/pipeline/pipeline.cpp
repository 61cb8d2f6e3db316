#include "predictive_stereo/pipeline.h"

#include <stdexcept>
#include <string>

#include "parallel/tasks.h"
#include "predictive_stereo/simd_target.h"

namespace predictive_stereo {
namespace {

std::string text(cv::Size size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

void requireSize(const char* name, const cv::Mat1b& image, cv::Size expected) {
  if (image.size() != expected)
    throw std::invalid_argument(std::string(name) + " image is " + text(image.size()) +
                                " but the calibration is for " + text(expected));
}

}  // namespace

Pipeline::Pipeline(const PipelineParams& params) : params_(params), guard_(params.max_gap) {
  if (params.parts.disparity) params_.detection.range = params.disparity.matcher.range;
  if (params.parts.ego_motion) ego_motion_.emplace(params_.ego_motion);
  if (params.parts.disparity) disparity_.emplace(params_.disparity);
  if (params.parts.disparity) useSimdTarget(params_.disparity.matcher.simd_target);
  if (params.parts.detection) detector_.emplace(params_.detection);
  validate(params);
}

Pipeline::~Pipeline() = default;

SequenceGuard::Result Pipeline::begin(const StereoFrame& frame) {
  requireSize("left", frame.left, frame.rig.size);
  if (ego_motion_ || disparity_) requireSize("right", frame.right, frame.rig.size);
  const SequenceGuard::Result sequence = guard_.next(frame.stamp, frame.rig);
  using Verdict = SequenceGuard::Verdict;
  if (sequence.verdict == Verdict::kDuplicate) return sequence;
  if (sequence.verdict == Verdict::kBackward) startAnew();
  if (sequence.verdict != Verdict::kContinues) forgetFrames();
  if (frame.rig != frame_.rig) column_offset_ = ColumnOffset();
  frame_ = frame;
  return sequence;
}

// The block diagram of the paper.
void Pipeline::process(const FrameSources& sources, PipelineOutput& output) {
  times_ = {};
  correctColumns(sources, output);
  if (!disparity_) {
    followCamera(sources, output);
    if (detector_) detect(output);
    return;
  }
  DisparityOutput& maps = output.disparity;
  DisparityState* filters = &past_;
  disparity_->begin(frame_.left, frame_.right, frame_.rig, rig_);
  const auto moveThePast = [&] {
    followCamera(sources, output);
    const std::optional<CameraMotion> motion = motionFromPast(sources, output);
    if (sources.moved && needsMovingMask()) markMoving(sources.moved(*past_stamp_));
    disparity_->predict(past_, motion, maps);
    filters = &linkToPast(motion.has_value());
  };
  runTogether(moveThePast, [&] { disparity_->matchCoarsely(); });
  disparity_->chooseRanges(maps);
  disparity_->match(maps);
  disparity_->correct(maps, *filters);
  if (filters == &past_) past_stamp_ = frame_.stamp;
  if (sources.measured) sources.measured();
  const auto detectMotion = [&] {
    if (detector_) detect(output);
  };
  runTogether(detectMotion, [&] { disparity_->publish(*filters, maps); });
  times_.disparity = disparity_->times();
  if (detector_) markMoving(output.detections.mask);
}

void Pipeline::correctColumns(const FrameSources& sources, PipelineOutput& output) {
  if (sources.column_offset) column_offset_ = *sources.column_offset;
  output.column_offset = column_offset_;
  if (!params_.disparity.correct_columns) output.column_offset.correction_px = 0;
  StereoRig corrected = frame_.rig;
  corrected.cx_right_px += output.column_offset.correction_px;
  const double step_px = corrected.cx_right_px - rig_.cx_right_px;
  if (step_px != 0) addToDisparities(params_.disparity.matcher.range, step_px, past_);
  rig_ = corrected;
}

// Estimates, or takes, the ego-motion, and updates the pose.
void Pipeline::followCamera(const FrameSources& sources, PipelineOutput& output) {
  output.motion_start.reset();
  if (!ego_motion_ && !sources.ego_motion) {
    output.pose = PoseEstimate();
    if (!sources.pose) return;
    output.pose.state = PoseState::kKnown;
    output.pose.T_odom_cam = output.pose.T_odom_body = sources.pose->T_odom_cam;
    output.pose.motion_covariance = sources.pose->motion_covariance;
    return;
  }
  Stopwatch watch;
  if (sources.ego_motion) {
    output.ego_motion = *sources.ego_motion;
  } else {
    const bool fits = sources.ignored.size() == frame_.rig.size && has_previous_;
    output.ego_motion =
        ego_motion_->estimate(frame_.left, frame_.right, frame_.rig,
                              fits ? sources.ignored : cv::Mat1b(), sources.R_cam_prev);
    watch.lap("ego-motion", times_.ego_motion);
  }
  column_offset_ = output.ego_motion.column_offset;
  path_.add(output.ego_motion, frame_.stamp, sources.T_body_cam);
  output.motion_start = path_.motionStart();
  output.pose = path_.pose();
  has_previous_ = true;
}

std::optional<CameraMotion> Pipeline::motionFromPast(const FrameSources& sources,
                                                     const PipelineOutput& output) {
  if (sources.motion) return sources.motion(past_stamp_);
  if (!output.motion_start) return {};
  if (output.motion_start == past_stamp_) return output.ego_motion.motion;
  forgetPast();  // later motions start from later frames, never from the past
  return {};
}

// The filters that the current frame writes: the past, or, for an unlinked frame, temporary ones.
DisparityState& Pipeline::linkToPast(bool motion_known) {
  const bool linked = motion_known || past_.empty();
  unlinked_frames_ = linked ? 0 : unlinked_frames_ + 1;
  if (!linked && unlinked_frames_ <= params_.disparity.correction.max_missed_frames)
    return unlinked_;
  unlinked_frames_ = 0;
  return past_;
}

void Pipeline::detect(PipelineOutput& output) {
  Stopwatch watch;
  const DisparityOutput& maps = output.disparity;
  detector_->detect(
      {toSeconds(frame_.stamp), rig_, frame_.left, maps.measured_disparity_px,
       maps.measured_variance_px2, maps.predicted_disparity_px, maps.predicted_variance_px2,
       output.pose.state, output.pose.T_odom_cam, output.pose.motion_covariance},
      output.detections);
  watch.lap("detection", times_.detection);
}

// Whether moving objects of the last frame must be masked: it is the past, and the option is on.
bool Pipeline::needsMovingMask() const {
  return params_.disparity.use_moving_mask && past_stamp_ && unlinked_frames_ == 0;
}

void Pipeline::markMoving(const cv::Mat1b& mask) {
  if (mask.empty() || !needsMovingMask()) return;
  if (mask.size() != past_.missed_frames.size())
    throw std::invalid_argument("mask of moving objects is " + text(mask.size()) +
                                " but the images are " + text(past_.missed_frames.size()) +
                                ": both must have one size");
  cv::bitwise_or(past_.missed_frames, mask, past_.missed_frames);
}

void Pipeline::setParams(const EgoMotionParams& params) {
  ego_motion_->setParams(params);
  params_.ego_motion = params;
}

void Pipeline::setParams(const DisparityParams& params) {
  disparity_->setParams(params);
  useSimdTarget(params.matcher.simd_target);
  const bool other_range = params.matcher.range != params_.disparity.matcher.range;
  params_.disparity = params;
  if (!other_range) return;
  forgetPast();
  if (detector_) setParams(params_.detection);
}

void Pipeline::setParams(const DetectionParams& params) {
  DetectionParams changed = params;
  if (disparity_) changed.range = params_.disparity.matcher.range;
  detector_->setParams(changed);
  params_.detection = changed;
}

void Pipeline::reset() {
  startAnew();
  forgetFrames();
  guard_.forget();
}

// A new EgoMotion: EgoMotion::reset() would keep the estimated disparity offset.
void Pipeline::startAnew() {
  if (ego_motion_) ego_motion_.emplace(params_.ego_motion);
  column_offset_ = ColumnOffset();
  path_.reset();
}

void Pipeline::forgetFrames() {
  if (ego_motion_) ego_motion_->reset();
  if (disparity_) disparity_->reset();
  if (detector_) detector_->reset();
  path_.breakOff();
  has_previous_ = false;
  forgetPast();
}

void Pipeline::forgetPast() {
  past_ = DisparityState();
  past_stamp_.reset();
  unlinked_frames_ = 0;
}

StageTimes PipelineTimes::all() const {
  StageTimes all = ego_motion;
  all.insert(all.end(), disparity.begin(), disparity.end());
  all.insert(all.end(), detection.begin(), detection.end());
  return all;
}

}  // namespace predictive_stereo
