#include "predictive_stereo/pipeline.h"

namespace predictive_stereo {
namespace {

DetectionParams withRange(DetectionParams params, const DisparityRange& range) {
  params.range = range;
  return params;
}

}  // namespace

Pipeline::Pipeline(const PipelineParams& params)
    : odometry_(params.ego_motion, params.max_gap),
      disparity_(params.disparity, params.max_gap),
      detection_params_(withRange(params.detection, params.disparity.matcher.range)),
      detector_(detection_params_) {
  validate(params);
}

SequenceGuard::Result Pipeline::begin(const StereoFrame& frame) {
  odometry_.begin(frame);
  const SequenceGuard::Result sequence = disparity_.begin(frame);
  if (sequence.isIgnored()) return sequence;
  if (sequence.verdict != SequenceGuard::Verdict::kContinues) detector_.reset();
  frame_ = frame;
  return sequence;
}

// The block diagram of the paper.
void Pipeline::process(const Follow& follow, PipelineOutput& output) {
  OdometryOutput& camera = output;
  const auto motion = [&](Past& past) {
    camera = follow();
    return past.motionBy(camera.ego_motion.motion, camera.motion_start);
  };
  disparity_.measure(motion, {}, output.disparity);
  output.column_offset = disparity_.columnOffset();
  disparity_.publish(output.disparity);
  detect(output);
  disparity_.eraseMoving(output.detections.mask);
  disparity_.setColumnOffset(camera.ego_motion.column_offset);
  times_.ego_motion = odometry_.times();
  times_.disparity = disparity_.times();
}

void Pipeline::detect(PipelineOutput& output) {
  times_.detection.clear();
  Stopwatch watch;
  const DisparityOutput& maps = output.disparity;
  detector_.detect(
      {toSeconds(frame_.stamp), disparity_.rig(), frame_.left, maps.measured_disparity_px,
       maps.measured_variance_px2, maps.predicted_disparity_px, maps.predicted_variance_px2,
       output.pose.state, output.pose.T_odom_cam, output.pose.motion_covariance},
      output.detections);
  watch.lap("detection", times_.detection);
}

void Pipeline::reset() {
  odometry_.reset();
  disparity_.reset();
  detector_.reset();
}

void Pipeline::setParams(const DisparityParams& params) {
  disparity_.setParams(params);
  if (params.matcher.range != detection_params_.range)
    setParams(withRange(detection_params_, params.matcher.range));
}

void Pipeline::setParams(const DetectionParams& params) {
  const DetectionParams changed = withRange(params, disparity_.params().matcher.range);
  detector_.setParams(changed);
  detection_params_ = changed;
}

StageTimes PipelineTimes::all() const {
  StageTimes all = ego_motion;
  all.insert(all.end(), disparity.begin(), disparity.end());
  all.insert(all.end(), detection.begin(), detection.end());
  return all;
}

}  // namespace predictive_stereo
