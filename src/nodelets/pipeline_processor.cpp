#include "nodelets/pipeline_processor.h"

#include <stdexcept>

namespace predictive_stereo {
namespace {

// Long, because all transforms of a recording may be added before its first frame is processed.
const ros::Duration kTfMemory(24 * 3600.0);

}  // namespace

PipelineProcessor::PipelineProcessor(const AllNodeletParams& params)
    : params_(params),
      tf_(kTfMemory),
      ego_motion_(params.ego_motion),
      disparity_(params.disparity),
      moving_objects_(params.moving_objects) {
  validate(params);
}

std::optional<PipelineProcessor::Output> PipelineProcessor::process(const StereoPair& pair) {
  const SequenceGuard::Result sequence = disparity_.begin(pair);
  if (sequence.isIgnored()) return std::nullopt;
  try {
    return processBegun(pair, sequence);
  } catch (...) {
    // Some processors have this frame, others do not: only a new start makes them agree.
    reset();
    throw;
  }
}

void PipelineProcessor::reset() {
  ego_motion_.reset();
  disparity_.reset();
  moving_objects_.reset();
  odometry_.clear();
  column_offset_ = ColumnOffset();
  moving_mask_.reset();
}

PipelineProcessor::Output PipelineProcessor::processBegun(const StereoPair& pair,
                                                          const SequenceGuard::Result& sequence) {
  const std_msgs::Header& header = pair.left->header;
  Output output;
  Stopwatch total;
  if (sequence.startsAnew()) output.event = sequence.reason;

  output.disparity = disparity_.process(
      {[&](const Past& past) { return followCamera(pair, past.stamp(), output); },
       [&](Stamp) { return movedMask(*moving_mask_, *pair.left); },
       {},
       column_offset_});
  column_offset_ = output.ego_motion.estimate.column_offset;
  output.times.insert(output.times.end(), disparity_.times().begin(), disparity_.times().end());

  Stopwatch watch;
  const PoseAnswer answer =
      cameraPose(tf_, &odometry_, header.frame_id, moving_objects_.lastWithPose(), header.stamp,
                 params_.moving_objects.odom_frame);
  output.moving_objects = moving_objects_.process(output.disparity, answer.value);
  moving_mask_ = output.moving_objects.mask;
  watch.lap("detection", output.times);
  total.lap("whole frame", output.times);
  return output;
}

// Runs the ego-motion, and gets the motion since the past frame from tf and the odometry.
std::optional<CameraMotion> PipelineProcessor::followCamera(const StereoPair& pair,
                                                            std::optional<Stamp> past,
                                                            Output& output) {
  const std_msgs::Header& header = pair.left->header;
  Stopwatch watch;
  output.ego_motion = ego_motion_.process(pair, extrinsic(pair));
  watch.lap("ego-motion", output.times);
  if (params_.ego_motion.publish_tf) tf_.setTransform(output.ego_motion.transform, "ego_motion");
  odometry_.add(output.ego_motion.odometry);
  if (!past) return std::nullopt;
  const MotionAnswer answer = cameraMotion(tf_, &odometry_, header.frame_id, rosTime(*past),
                                           header.stamp, params_.disparity.odom_frame);
  if (!answer.value) output.event = answer.reason + ": matched without prediction";
  return answer.value;
}

Eigen::Isometry3d PipelineProcessor::extrinsic(const StereoPair& pair) const {
  if (ego_motion_.cameraIsBase(pair)) return Eigen::Isometry3d::Identity();
  std::string error;
  const auto T_base_cam = lookUpTransform(
      tf_, ego_motion_.baseFrame(pair), pair.left->header.frame_id, pair.left->header.stamp, error);
  if (!T_base_cam)
    throw std::invalid_argument("no transform from base_frame '" + ego_motion_.baseFrame(pair) +
                                "' to the left camera: " + error);
  return *T_base_cam;
}

}  // namespace predictive_stereo
