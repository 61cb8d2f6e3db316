#include "predictive_stereo/disparity_estimator.h"

#include <sstream>
#include <stdexcept>
#include <utility>

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

DisparityEstimator::DisparityEstimator(const DisparityParams& params)
    : params_(params),
      coarse_matcher_(params.matcher, params.min_region_px),
      row_aligner_(params.row_alignment),
      predictor_(params.matcher.range, params.prediction),
      range_builder_(params.matcher.range, params.search),
      matcher_(params.matcher) {
  validate(params);
}

void DisparityEstimator::begin(const cv::Mat1b& left, const cv::Mat1b& right,
                               const StereoRig& calibration, const StereoRig& rig) {
  requirePartners(params_.matcher.range, calibration);
  rig_ = rig;
  principal_offset_px_ = calibration.principalOffset();
  right_shift_px_ = rig.principalOffset() - principal_offset_px_;
  left_ = left;
  right_ = right;
}

void DisparityEstimator::matchCoarsely() {
  coarse_times_.clear();
  Stopwatch watch;

  alignRightImage(right_, RowOffsetModel(), right_shift_px_, shifted_right_);
  const bool align = params_.row_alignment.enabled;
  if (align || params_.search.scheme == SearchScheme::kPredictive) {
    coarse_matcher_.match(left_, shifted_right_, coarse_disparity_px_, principal_offset_px_);
    watch.lap("half-resolution match", coarse_times_);
  }

  row_alignment_ = RowOffsetModel();
  if (align)
    row_alignment_ = row_aligner_.estimate(left_, shifted_right_, coarse_disparity_px_,
                                           params_.matcher.range, principal_offset_px_);
  alignRightImage(shifted_right_, row_alignment_, 0.0, aligned_right_);
  if (align) watch.lap("row alignment", coarse_times_);
}

void DisparityEstimator::predict(const DisparityState& past,
                                 const std::optional<CameraMotion>& motion,
                                 DisparityOutput& output) {
  prediction_.disparity_px = output.predicted_disparity_px;
  prediction_.variance_px2 = output.predicted_variance_px2;
  times_.clear();
  Stopwatch watch;

  output.predicted = motion.has_value() && !past.empty();
  if (output.predicted)
    predictor_.predict(past, rig_, *motion, prediction_);
  else
    predictor_.predictNothing(rig_.size, prediction_);
  output.predicted_disparity_px = prediction_.disparity_px;
  output.predicted_variance_px2 = prediction_.variance_px2;
  watch.lap("prediction", times_);
}

void DisparityEstimator::chooseRanges(DisparityOutput& output) {
  times_.insert(times_.begin(), coarse_times_.begin(), coarse_times_.end());
  output.row_alignment = row_alignment_;
  Stopwatch watch;
  range_builder_.build(prediction_, coarse_disparity_px_, ranges_);
  searchWidths(ranges_, output.search_width_px);
  watch.lap("search ranges", times_);
}

void DisparityEstimator::match(DisparityOutput& output) {
  const DisparityRange& range = params_.matcher.range;
  match_.ambiguity = output.ambiguity;
  Stopwatch watch;

  matcher_.match(left_, aligned_right_, ranges_, match_, principal_offset_px_);
  watch.lap("matching", times_);

  filterBySupport(range, params_.min_support, match_.disparity_px, output.measured_disparity_px);
  region_filter_.filter(range, params_.min_region_px, output.measured_disparity_px);
  measurementVariance(output.measured_disparity_px, match_.ambiguity, range, params_.variance,
                      output.measured_variance_px2);
  output.ambiguity = match_.ambiguity;
  watch.lap("support", times_);
}

void DisparityEstimator::correct(const DisparityOutput& output, DisparityState& filters) {
  const DisparityRange& range = params_.matcher.range;
  Stopwatch watch;
  predictive_stereo::correct(prediction_, output.measured_disparity_px, range, params_.correction,
                             filters, principal_offset_px_);
  std::swap(filters.disparity_px, corrected_disparity_px_);
  filterBySupport(range, params_.min_support, corrected_disparity_px_, filters.disparity_px);
  watch.lap("correction", times_);
}

void DisparityEstimator::publish(const DisparityState& filters, DisparityOutput& output) {
  const DisparityRange& range = params_.matcher.range;
  Stopwatch watch;
  leaveOutAmbiguous(range, output.measured_disparity_px, output.ambiguity, params_.max_ambiguity,
                    filters.disparity_px, certain_disparity_px_);
  region_filter_.filter(range, params_.min_region_px, certain_disparity_px_);
  fillHoles(range, params_.max_hole_px, kHoleTolerancePx, certain_disparity_px_,
            filled_disparity_px_);
  median3x3(range, params_.max_hole_px > 0 ? kBorderOfHole : kMajority, filled_disparity_px_,
            median_disparity_px_);
  predictive_stereo::publish(median_disparity_px_, certain_disparity_px_, prediction_,
                             output.measured_disparity_px, output.measured_variance_px2,
                             output.ambiguity, row_alignment_.rms_offset_px, range,
                             params_.variance, output.disparity_px, output.disparity_variance_px2);
  watch.lap("median", times_);
}

void DisparityEstimator::setParams(const DisparityParams& params) {
  DisparityEstimator changed(params);
  params_ = params;
  row_aligner_.setParams(params.row_alignment);
  coarse_matcher_ = std::move(changed.coarse_matcher_);
  predictor_ = std::move(changed.predictor_);
  range_builder_ = std::move(changed.range_builder_);
  matcher_ = std::move(changed.matcher_);
}

}  // namespace predictive_stereo
