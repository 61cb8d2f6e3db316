#include "predictive_stereo/disparity_loop.h"

#include "parallel/tasks.h"
#include "predictive_stereo/simd_target.h"

namespace predictive_stereo {

DisparityLoop::DisparityLoop(const DisparityParams& params, double max_gap_s)
    : params_(params), estimator_(params), guard_(max_gap_s) {
  useSimdTarget(params.matcher.simd_target);
}

SequenceGuard::Result DisparityLoop::begin(const StereoFrame& frame) {
  requireSizes(frame);
  const SequenceGuard::Result sequence = guard_.next(frame.stamp, frame.rig);
  using Verdict = SequenceGuard::Verdict;
  if (sequence.isIgnored()) return sequence;
  if (sequence.verdict == Verdict::kBackward || frame.rig != frame_.rig)
    next_offset_ = ColumnOffset();
  if (sequence.verdict != Verdict::kContinues) {
    estimator_.reset();
    past_.forget();
  }
  frame_ = frame;
  return sequence;
}

void DisparityLoop::measure(const Motion& motion, const Moved& moved, DisparityOutput& maps) {
  correctColumns();
  estimator_.begin(frame_.left, frame_.right, frame_.rig, rig_);
  const auto moveThePast = [&] {
    const std::optional<CameraMotion> since_past = motion(past_);
    if (moved && params_.use_moving_mask && past_.isLastFrame()) eraseMoving(moved(*past_.stamp()));
    estimator_.predict(past_.filters(), since_past, maps);
    past_.link(since_past.has_value(), params_.correction.max_missed_frames);
  };
  runTogether(moveThePast, [&] { estimator_.matchCoarsely(); });
  estimator_.chooseRanges(maps);
  estimator_.match(maps);
  estimator_.correct(maps, past_.current());
  past_.carry(frame_.stamp);
}

void DisparityLoop::correctColumns() {
  offset_ = next_offset_;
  if (!params_.correct_columns) offset_.correction_px = 0;
  rig_ = corrected(frame_.rig, offset_);
  past_.setRig(params_.matcher.range, rig_);
}

void DisparityLoop::eraseMoving(const cv::Mat1b& mask) {
  if (params_.use_moving_mask) past_.eraseMoving(mask);
}

void DisparityLoop::setParams(const DisparityParams& params) {
  estimator_.setParams(params);
  useSimdTarget(params.matcher.simd_target);
  if (params.matcher.range != params_.matcher.range) past_.forget();
  params_ = params;
}

void DisparityLoop::reset() {
  estimator_.reset();
  past_.forget();
  next_offset_ = ColumnOffset();
  guard_.forget();
}

}  // namespace predictive_stereo
