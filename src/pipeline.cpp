#include "predictive_stereo/pipeline.h"

#include <future>
#include <stdexcept>
#include <string>
#include <utility>

#include "predictive_stereo/rigid_motion.h"

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

void DisparityEstimator::begin(const cv::Mat1b& left, const cv::Mat1b& right,
                               const StereoRig& rig) {
  requireSize("left", left, rig.size);
  requireSize("right", right, rig.size);
  if (rig != rig_) reset();
  rig_ = rig;
  left_ = left;
  right_ = right;
}

void DisparityEstimator::matchCoarsely() {
  coarse_times_.clear();
  Stopwatch watch;

  alignRightImage(right_, RowOffsetModel(), rig_.cx_left_px - rig_.cx_right_px, shifted_right_);
  coarse_matcher_.match(left_, shifted_right_, coarse_disparity_px_);
  watch.lap("half-resolution match", coarse_times_);

  row_alignment_ =
      row_aligner_.estimate(left_, shifted_right_, coarse_disparity_px_, params_.matcher.range);
  alignRightImage(shifted_right_, row_alignment_, 0.0, aligned_right_);
  watch.lap("row alignment", coarse_times_);
}

void DisparityEstimator::predict(const std::optional<CameraMotion>& motion,
                                 DisparityOutput& output) {
  prediction_.disparity_px = output.predicted_disparity_px;
  prediction_.variance_px2 = output.predicted_variance_px2;
  times_.clear();
  Stopwatch watch;

  output.predicted = motion.has_value() && !past_.empty();
  unlinked_frames_ = motion || past_.empty() ? 0 : unlinked_frames_ + 1;
  output.carried = unlinked_frames_ == 0 || unlinked_frames_ > params_.correction.max_missed_frames;
  if (output.carried) unlinked_frames_ = 0;
  if (output.predicted)
    predictor_.predict(past_, rig_, *motion, prediction_);
  else
    predictor_.predictNothing(rig_.size, prediction_);
  output.predicted_disparity_px = prediction_.disparity_px;
  output.predicted_variance_px2 = prediction_.variance_px2;
  watch.lap("prediction", times_);
}

// The block diagram of the paper, from the prediction on.
void DisparityEstimator::measure(DisparityOutput& output) {
  const DisparityRange& range = params_.matcher.range;
  DisparityState& state = output.carried ? past_ : unlinked_;
  match_.ambiguity = output.ambiguity;
  times_.insert(times_.begin(), coarse_times_.begin(), coarse_times_.end());
  Stopwatch watch;

  range_builder_.build(prediction_, coarse_disparity_px_, ranges_);
  searchWidths(ranges_, output.search_width_px);
  watch.lap("search ranges", times_);

  matcher_.match(left_, aligned_right_, ranges_, match_);
  watch.lap("matching", times_);

  filterBySupport(range, params_.min_support, match_.disparity_px, output.measured_disparity_px);
  measurementVariance(output.measured_disparity_px, match_.ambiguity, range, params_.variance,
                      output.measured_variance_px2);
  watch.lap("support", times_);

  correct(prediction_, output.measured_disparity_px, range, params_.correction, state);
  std::swap(state.disparity_px, corrected_disparity_px_);
  filterBySupport(range, params_.min_support, corrected_disparity_px_, state.disparity_px);
  watch.lap("correction", times_);

  output.ambiguity = match_.ambiguity;
  output.row_alignment = row_alignment_;
}

void DisparityEstimator::publish(DisparityOutput& output) {
  const DisparityRange& range = params_.matcher.range;
  const DisparityState& state = output.carried ? past_ : unlinked_;
  Stopwatch watch;
  fillHolesAndMedian3x3(range, params_.max_hole_px, kHoleTolerancePx, state.disparity_px,
                        median_disparity_px_);
  predictive_stereo::publish(median_disparity_px_, state, prediction_, output.measured_disparity_px,
                             output.measured_variance_px2, row_alignment_.rms_offset_px, range,
                             params_.variance, output.disparity_px, output.disparity_variance_px2);
  watch.lap("median", times_);
}

void DisparityEstimator::markMoving(const cv::Mat1b& mask) {
  if (!params_.use_moving_mask || past_.empty() || unlinked_frames_ > 0) return;
  if (mask.size() != past_.missed_frames.size())
    throw std::invalid_argument("mask of moving objects is " + text(mask.size()) +
                                " but the frame was " + text(past_.missed_frames.size()));
  cv::bitwise_or(past_.missed_frames, mask, past_.missed_frames);
}

void DisparityEstimator::setParams(const DisparityParams& params) {
  DisparityEstimator changed(params);
  if (params.matcher.range != params_.matcher.range) forgetPast();
  params_ = params;
  row_aligner_.setParams(params.row_alignment);
  coarse_matcher_ = std::move(changed.coarse_matcher_);
  predictor_ = std::move(changed.predictor_);
  range_builder_ = std::move(changed.range_builder_);
  matcher_ = std::move(changed.matcher_);
}

void DisparityEstimator::reset() {
  row_aligner_.reset();
  forgetPast();
}

void DisparityEstimator::forgetPast() {
  past_ = DisparityState();
  unlinked_frames_ = 0;
}

Pipeline::Pipeline(const PipelineParams& params)
    : ego_motion_(params.ego_motion), disparity_(params.disparity), detector_(params.detection) {}

void Pipeline::process(const cv::Mat1b& left, const cv::Mat1b& right, const StereoRig& rig,
                       double stamp_s, PipelineOutput& output) {
  // What needs no motion runs beside it.
  disparity_.begin(left, right, rig);
  auto matched_coarsely = std::async(std::launch::async, [&] { disparity_.matchCoarsely(); });
  Stopwatch watch;
  output.ego_motion = ego_motion_.estimate(left, right, rig);
  const bool tracked = output.ego_motion.status == EgoMotionStatus::kTracked;
  // Of the first frame the pose is known, too: it is where odom begins.
  const bool known = output.ego_motion.status != EgoMotionStatus::kLost;
  T_odom_cam_ = compose(T_odom_cam_, output.ego_motion.motion.T_cam_prev.inverse());
  output.T_odom_cam = T_odom_cam_;
  times_.clear();
  watch.lap("ego-motion", times_);

  ++frames_since_past_;
  const bool from_past = output.ego_motion.frames == frames_since_past_;
  if (tracked && !from_past) disparity_.forgetPast();
  disparity_.predict(tracked && from_past ? std::optional(output.ego_motion.motion) : std::nullopt,
                     output.disparity);
  matched_coarsely.get();
  disparity_.measure(output.disparity);
  if (output.disparity.carried) frames_since_past_ = 0;

  // The detector does not need it, but keeps all threads busy itself.
  disparity_.publish(output.disparity);
  times_.insert(times_.end(), disparity_.times().begin(), disparity_.times().end());
  watch = Stopwatch();

  detector_.detect({stamp_s, rig, left, output.disparity.measured_disparity_px,
                    output.disparity.measured_variance_px2, output.disparity.predicted_disparity_px,
                    output.disparity.predicted_variance_px2, known, output.T_odom_cam},
                   output.detections);
  disparity_.markMoving(output.detections.mask);
  watch.lap("detection", times_);
}

void Pipeline::reset() {
  ego_motion_.reset();
  disparity_.reset();
  detector_.reset();
  T_odom_cam_ = Eigen::Isometry3d::Identity();
  frames_since_past_ = 0;
}

}  // namespace predictive_stereo
