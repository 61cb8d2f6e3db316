#include "predictive_stereo/disparity_loop.h"

#include <sstream>
#include <stdexcept>
#include <utility>

#include "parallel/tasks.h"
#include "predictive_stereo/simd_target.h"

namespace predictive_stereo {
namespace {

constexpr float kHoleTolerancePx = 3.0f;
// Known neighbours with which the median fills a pixel.
constexpr int kBorderOfHole = 3, kMajority = 5;

void requirePartners(const DisparityRange& range, const StereoRig& rig) {
  if (leavesPartners(range, rig.principalOffset(), rig.size.width)) return;
  std::ostringstream text;
  text << "cx_left - cx_right is " << rig.principalOffset() << " px: at disparities of "
       << range.min_disparity << " to " << range.max_disparity()
       << " px no pixel of the left image is in the right one, which has " << rig.size.width
       << " columns; calibrate both cameras together, or set matcher/range";
  throw std::invalid_argument(text.str());
}

}  // namespace

DisparityLoop::Stages::Stages(const DisparityParams& params)
    : coarse_matcher(params.matcher, params.min_region_px),
      row_aligner(params.row_alignment),
      predictor(params.matcher.range, params.prediction),
      range_builder(params.matcher.range, params.search),
      matcher(params.matcher) {
  validate(params);
}

DisparityLoop::DisparityLoop(const DisparityParams& params, double max_gap_s)
    : params_(params), stages_(params), guard_(max_gap_s) {
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
    stages_.row_aligner.reset();
    past_.forget();
  }
  frame_ = frame;
  return sequence;
}

void DisparityLoop::measure(const Motion& motion, const Moved& moved, DisparityOutput& maps) {
  correctColumns();
  requirePartners(params_.matcher.range, frame_.rig);
  const auto moveThePast = [&] {
    const std::optional<CameraMotion> since_past = motion(past_);
    if (moved && params_.use_moving_mask && past_.isLastFrame()) eraseMoving(moved(*past_.stamp()));
    predict(since_past, maps);
    past_.link(since_past.has_value(), params_.correction.max_missed_frames);
  };
  runTogether(moveThePast, [&] { matchCoarsely(); });
  chooseRanges(maps);
  match(maps);
  correct(maps);
  past_.carry(frame_.stamp);
}

void DisparityLoop::correctColumns() {
  offset_ = next_offset_;
  if (!params_.correct_columns) offset_.correction_px = 0;
  rig_ = corrected(frame_.rig, offset_);
  past_.setRig(params_.matcher.range, rig_);
}

void DisparityLoop::matchCoarsely() {
  coarse_times_.clear();
  Stopwatch watch;

  const double offset_px = frame_.rig.principalOffset();
  alignRightImage(frame_.right, RowOffsetModel(), rig_.principalOffset() - offset_px,
                  shifted_right_);
  const bool align = params_.row_alignment.enabled;
  if (align || params_.search.scheme == SearchScheme::kPredictive) {
    stages_.coarse_matcher.match(frame_.left, shifted_right_, coarse_disparity_px_, offset_px);
    watch.lap("half-resolution match", coarse_times_);
  }

  row_alignment_ = RowOffsetModel();
  if (align)
    row_alignment_ = stages_.row_aligner.estimate(frame_.left, shifted_right_, coarse_disparity_px_,
                                                  params_.matcher.range, offset_px);
  alignRightImage(shifted_right_, row_alignment_, 0.0, aligned_right_);
  if (align) watch.lap("row alignment", coarse_times_);
}

void DisparityLoop::predict(const std::optional<CameraMotion>& motion, DisparityOutput& maps) {
  prediction_.disparity_px = maps.predicted_disparity_px;
  prediction_.variance_px2 = maps.predicted_variance_px2;
  times_.clear();
  Stopwatch watch;

  maps.predicted = motion.has_value() && !past_.filters().empty();
  if (maps.predicted)
    stages_.predictor.predict(past_.filters(), rig_, *motion, prediction_);
  else
    stages_.predictor.predictNothing(rig_.size, prediction_);
  maps.predicted_disparity_px = prediction_.disparity_px;
  maps.predicted_variance_px2 = prediction_.variance_px2;
  watch.lap("prediction", times_);
}

void DisparityLoop::chooseRanges(DisparityOutput& maps) {
  times_.insert(times_.begin(), coarse_times_.begin(), coarse_times_.end());
  maps.row_alignment = row_alignment_;
  Stopwatch watch;
  stages_.range_builder.build(prediction_, coarse_disparity_px_, ranges_);
  searchWidths(ranges_, maps.search_width_px);
  watch.lap("search ranges", times_);
}

void DisparityLoop::match(DisparityOutput& maps) {
  const DisparityRange& range = params_.matcher.range;
  match_.ambiguity = maps.ambiguity;
  Stopwatch watch;

  stages_.matcher.match(frame_.left, aligned_right_, ranges_, match_, frame_.rig.principalOffset());
  watch.lap("matching", times_);

  filterBySupport(range, params_.min_support, match_.disparity_px, maps.measured_disparity_px);
  region_filter_.filter(range, params_.min_region_px, maps.measured_disparity_px);
  leaveOutRobot(maps.measured_disparity_px);
  measurementVariance(maps.measured_disparity_px, match_.ambiguity, range, params_.variance,
                      maps.measured_variance_px2);
  maps.ambiguity = match_.ambiguity;
  watch.lap("support", times_);
}

void DisparityLoop::correct(const DisparityOutput& maps) {
  const DisparityRange& range = params_.matcher.range;
  DisparityState& filters = past_.current();
  Stopwatch watch;
  predictive_stereo::correct(prediction_, maps.measured_disparity_px, range, params_.correction,
                             filters, frame_.rig.principalOffset());
  std::swap(filters.disparity_px, corrected_disparity_px_);
  filterBySupport(range, params_.min_support, corrected_disparity_px_, filters.disparity_px);
  watch.lap("correction", times_);
}

void DisparityLoop::publish(DisparityOutput& maps) {
  const DisparityRange& range = params_.matcher.range;
  Stopwatch watch;
  leaveOutAmbiguous(range, maps.measured_disparity_px, maps.ambiguity, params_.max_ambiguity,
                    past_.current().disparity_px, certain_disparity_px_);
  region_filter_.filter(range, params_.min_region_px, certain_disparity_px_);
  fillHoles(range, params_.max_hole_px, kHoleTolerancePx, certain_disparity_px_,
            filled_disparity_px_);
  median3x3(range, params_.max_hole_px > 0 ? kBorderOfHole : kMajority, filled_disparity_px_,
            median_disparity_px_);
  leaveOutRobot(median_disparity_px_);
  photometric_residual_.measure(frame_.left, aligned_right_, median_disparity_px_, range,
                                frame_.rig.principalOffset(), residual_share_);
  predictive_stereo::publish(
      median_disparity_px_,
      {certain_disparity_px_, prediction_.disparity_px, maps.measured_disparity_px,
       maps.measured_variance_px2, maps.ambiguity, residual_share_, row_alignment_.rms_offset_px},
      range, params_.variance, maps.disparity_px, maps.disparity_variance_px2);
  watch.lap("median", times_);
}

void DisparityLoop::leaveOutRobot(cv::Mat1f& disparity_px) const {
  if (!frame_.robot_mask.empty())
    disparity_px.setTo(params_.matcher.range.invalid(), frame_.robot_mask);
}

void DisparityLoop::eraseMoving(const cv::Mat1b& mask) {
  if (params_.use_moving_mask) past_.eraseMoving(mask);
}

void DisparityLoop::setParams(const DisparityParams& params) {
  Stages changed(params);
  changed.row_aligner = std::move(stages_.row_aligner);  // with its past frames
  changed.row_aligner.setParams(params.row_alignment);
  stages_ = std::move(changed);
  useSimdTarget(params.matcher.simd_target);
  if (params.matcher.range != params_.matcher.range) past_.forget();
  params_ = params;
}

void DisparityLoop::reset() {
  stages_.row_aligner.reset();
  past_.forget();
  next_offset_ = ColumnOffset();
  guard_.forget();
}

}  // namespace predictive_stereo
