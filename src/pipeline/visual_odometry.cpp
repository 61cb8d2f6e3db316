#include "predictive_stereo/visual_odometry.h"

#include "imaging/size_check.h"

namespace predictive_stereo {

void requireSizes(const StereoFrame& frame) {
  requireSize("left image", frame.left.size(), frame.rig.size);
  requireSize("right image", frame.right.size(), frame.rig.size);
  if (!frame.robot_mask.empty()) requireSize("robot_mask", frame.robot_mask.size(), frame.rig.size);
}

VisualOdometry::VisualOdometry(const EgoMotionParams& params, double max_gap_s)
    : params_(params), ego_motion_(params), guard_(max_gap_s) {}

SequenceGuard::Result VisualOdometry::begin(const StereoFrame& frame) {
  requireSizes(frame);
  const SequenceGuard::Result sequence = guard_.next(frame.stamp, frame.rig);
  using Verdict = SequenceGuard::Verdict;
  if (sequence.isIgnored()) return sequence;
  if (sequence.verdict == Verdict::kBackward) startAnew();
  if (sequence.verdict != Verdict::kContinues) forgetFrames();
  frame_ = frame;
  return sequence;
}

const OdometryOutput& VisualOdometry::follow(const OdometryHints& hints) {
  times_.clear();
  Stopwatch watch;
  cv::Mat1b ignored = frame_.robot_mask;
  if (hints.ignored.size() == frame_.rig.size && has_previous_)
    ignored = ignored.empty() ? hints.ignored : cv::Mat1b(ignored | hints.ignored);
  output_.ego_motion =
      ego_motion_.estimate(frame_.left, frame_.right, frame_.rig, ignored, hints.R_cam_prev,
                           toSeconds(frame_.stamp - previous_stamp_));
  previous_stamp_ = frame_.stamp;
  watch.lap("ego-motion", times_);
  path_.add(output_.ego_motion, frame_.stamp, hints.T_body_cam);
  output_.motion_start = path_.motionStart();
  output_.pose = path_.pose();
  has_previous_ = true;
  return output_;
}

void VisualOdometry::setParams(const EgoMotionParams& params) {
  ego_motion_.setParams(params);
  params_ = params;
}

void VisualOdometry::reset() {
  startAnew();
  forgetFrames();
  guard_.forget();
}

// A new EgoMotion: EgoMotion::reset() would keep the estimated disparity offset.
void VisualOdometry::startAnew() {
  ego_motion_ = EgoMotion(params_);
  path_.reset();
}

void VisualOdometry::forgetFrames() {
  ego_motion_.reset();
  path_.breakOff();
  has_previous_ = false;
}

}  // namespace predictive_stereo
