#include "predictive_stereo/pipeline.h"

#include <stdexcept>
#include <string>

namespace predictive_stereo {
namespace {

constexpr float kHoleTolerancePx = 3.0f;

std::string text(cv::Size size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

void requireSize(const char* name, const cv::Mat1b& image, cv::Size expected) {
  if (image.size() != expected)
    throw std::invalid_argument(std::string(name) + " image is " + text(image.size()) +
                                " but the calibration is for " + text(expected));
}

}  // namespace

DisparityEstimator::DisparityEstimator(const DisparityParams& params)
    : params_(params),
      coarse_matcher_(params.matcher),
      row_aligner_(params.row_alignment),
      predictor_(params.matcher.range, params.prediction),
      range_builder_(params.matcher.range, params.search),
      matcher_(params.matcher) {
  validate(params);
}

void DisparityEstimator::prepare(const cv::Mat1b& left, const cv::Mat1b& right,
                                 const StereoRig& rig) {
  requireSize("left", left, rig.size);
  requireSize("right", right, rig.size);
  if (rig != rig_) reset();
  rig_ = rig;
  left_ = left;
  times_.clear();
  Stopwatch watch;

  alignRightImage(right, RowAlignment(), rig.cx_left_px - rig.cx_right_px, shifted_right_);
  coarse_matcher_.match(left_, shifted_right_, coarse_disparity_px_);
  watch.lap("half-resolution match", times_);

  row_alignment_ =
      row_aligner_.estimate(left_, shifted_right_, coarse_disparity_px_, params_.matcher.range);
  alignRightImage(shifted_right_, row_alignment_, 0.0, aligned_right_);
  watch.lap("row alignment", times_);
}

// The block diagram of the paper. Prediction and match are written into the caller's memory.
void DisparityEstimator::estimate(const std::optional<CameraMotion>& motion,
                                  DisparityOutput& output) {
  const DisparityRange& range = params_.matcher.range;
  prediction_.disparity_px = output.predicted_disparity_px;
  prediction_.variance_px2 = output.predicted_variance_px2;
  match_.search_width = output.search_width_px;
  match_.ambiguity = output.ambiguity;
  Stopwatch watch;

  output.predicted = motion.has_value() && !state_.empty();
  if (output.predicted)
    predictor_.predict(state_, rig_, *motion, prediction_);
  else
    predictor_.predictNothing(rig_.size, prediction_);
  watch.lap("prediction", times_);

  range_builder_.build(prediction_, coarse_disparity_px_, ranges_);
  watch.lap("search ranges", times_);

  matcher_.match(left_, aligned_right_, ranges_, match_);
  watch.lap("matching", times_);

  filterBySupport(range, params_.min_support, match_.disparity_px, output.measured_disparity_px);
  measurementVariance(output.measured_disparity_px, match_.ambiguity, range, params_.variance,
                      output.measured_variance_px2);
  watch.lap("support", times_);

  correct(prediction_, output.measured_disparity_px, range, params_.correction, state_);
  std::swap(state_.disparity_px, corrected_disparity_px_);
  filterBySupport(range, params_.min_support, corrected_disparity_px_, state_.disparity_px);
  watch.lap("correction", times_);

  state_.disparity_px.copyTo(filled_disparity_px_);
  fillHoles(range, params_.max_hole_px, kHoleTolerancePx, filled_disparity_px_);
  median3x3(range, filled_disparity_px_, output.disparity_px);
  publishedVariance(output.disparity_px, state_, prediction_, output.measured_disparity_px,
                    output.measured_variance_px2, range, params_.variance,
                    output.disparity_variance_px2);
  watch.lap("median", times_);

  output.predicted_disparity_px = prediction_.disparity_px;
  output.predicted_variance_px2 = prediction_.variance_px2;
  output.search_width_px = match_.search_width;
  output.ambiguity = match_.ambiguity;
  output.row_alignment = row_alignment_;
}

void DisparityEstimator::reset() {
  row_aligner_.reset();
  state_ = DisparityState();
}

}  // namespace predictive_stereo
