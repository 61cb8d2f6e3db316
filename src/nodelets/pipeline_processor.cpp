#include "nodelets/pipeline_processor.h"

#include <future>
#include <stdexcept>
#include <utility>

#include "nodelets/transforms.h"

namespace predictive_stereo {
namespace {

// A recording's whole tf may be put in before its first frame is processed.
const ros::Duration kTfMemory(24 * 3600.0);

}  // namespace

PipelineProcessor::PipelineProcessor(const AllNodeletParams& params)
    : params_(params),
      tf_(kTfMemory),
      ego_motion_(params.ego_motion.processor),
      disparity_(params.disparity.processor),
      moving_objects_(params.moving_objects.processor) {
  validate(params);
}

std::optional<PipelineProcessor::Output> PipelineProcessor::process(const StereoPair& pair) {
  const std_msgs::Header& header = pair.left->header;
  Output output;
  Stopwatch total;

  const SequenceGuard::Result sequence = disparity_.begin(pair);
  if (sequence.verdict == SequenceGuard::Verdict::kDuplicate) return std::nullopt;
  // Beside it ego-motion, as in the nodelets, and prediction.
  auto matched_coarsely = std::async(std::launch::async, [&] { disparity_.matchCoarsely(); });
  Stopwatch watch;
  EgoMotionProcessor::Output ego_motion = ego_motion_.process(pair, extrinsic(pair));
  watch.lap("ego-motion", output.times);
  if (!ego_motion.messages) return std::nullopt;
  if (sequence.verdict != SequenceGuard::Verdict::kContinues &&
      sequence.verdict != SequenceGuard::Verdict::kFirst)
    output.event = sequence.reason;
  output.ego_motion = std::move(*ego_motion.messages);
  output.estimate = ego_motion.estimate;
  if (params_.ego_motion.publish_tf) tf_.setTransform(output.ego_motion.transform, "ego_motion");
  odometry_.add(output.ego_motion.odometry);

  disparity_.predict(motion(header, output.event));
  matched_coarsely.get();
  output.disparity = disparity_.estimate();
  // The detector does not need it, but keeps all threads busy itself.
  disparity_.finish();
  output.times.insert(output.times.end(), disparity_.times().begin(), disparity_.times().end());
  watch = Stopwatch();
  std::string no_pose;
  output.T_odom_cam =
      lookUp(tf_, params_.moving_objects.odom_frame, header.frame_id, header.stamp, no_pose);
  MovingObjectsInput input;
  input.left = pair.left;
  input.left_info = pair.left_info;
  input.measured_disparity = output.disparity.measured_disparity;
  input.predicted_disparity = output.disparity.predicted_disparity;
  input.measured_variance = output.disparity.measured_variance;
  input.predicted_variance = output.disparity.predicted_variance;
  output.moving_objects = *moving_objects_.process(input, output.T_odom_cam).messages;
  disparity_.markMoving(*output.moving_objects.mask);
  watch.lap("detection", output.times);
  total.lap("whole frame", output.times);
  return output;
}

Eigen::Isometry3d PipelineProcessor::extrinsic(const StereoPair& pair) const {
  if (ego_motion_.cameraIsBase(pair)) return Eigen::Isometry3d::Identity();
  std::string error;
  const auto T_base_cam = lookUp(tf_, ego_motion_.baseFrame(pair), pair.left->header.frame_id,
                                 pair.left->header.stamp, error);
  if (!T_base_cam)
    throw std::invalid_argument("no transform from base_frame '" + ego_motion_.baseFrame(pair) +
                                "' to the left camera: " + error);
  return *T_base_cam;
}

std::optional<CameraMotion> PipelineProcessor::motion(const std_msgs::Header& now,
                                                      std::string& why) const {
  const std::optional<ros::Time> previous = disparity_.previousStamp();
  if (!previous) return std::nullopt;
  const MotionAnswer answer = cameraMotion(tf_, &odometry_, now.frame_id, *previous, now.stamp,
                                           params_.disparity.odom_frame);
  if (!answer.motion) why = answer.reason + ": matched without prediction";
  return answer.motion;
}

}  // namespace predictive_stereo
