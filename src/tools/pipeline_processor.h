#pragma once

#include <tf2/buffer_core.h>

#include <functional>
#include <optional>
#include <stdexcept>
#include <string>

#include "nodelets/nodelet_params.h"
#include "nodelets/output_topics.h"
#include "nodelets/transforms.h"
#include "predictive_stereo/stage_times.h"

namespace predictive_stereo {

/// The three processors, connected like the nodelets: Disparity gets the motion from tf and from
/// the odometry message, and the mask of moving objects. So its results are identical to theirs.
class PipelineProcessor {
 public:
  struct Output {
    EgoMotionProcessor::Output ego_motion;
    DisparityMessages disparity;
    MovingObjectsProcessor::Output moving_objects;
    CloudSource clouds;
    std::string event;  ///< why this frame starts a new sequence or has no prediction; else empty
    StageTimes times;
  };

  /// @param tf  gets the poses. The caller adds transforms of other publishers: base_frame ->
  ///   camera, and the camera's motion if EgoMotion does not publish it. Must outlive this object.
  PipelineProcessor(const AllNodeletParams& params, tf2::BufferCore& tf)
      : params_(params),
        tf_(tf),
        ego_motion_(params.ego_motion),
        disparity_(params.disparity),
        moving_objects_(params.moving_objects) {
    validate(params);
  }

  /// That of the disparity, see simd_target.h; empty: no warning.
  std::string slowTargetWarning() const { return disparity_.slowTargetWarning(); }

  /// @returns none if the pair has the stamp of the previous one.
  /// @throws std::invalid_argument for a pair that cannot be used: the state stays as it was; or if
  ///   tf lacks base_frame -> camera: the next pair is the first one then.
  std::optional<Output> process(const StereoPair& pair) {
    const SequenceGuard::Result sequence = disparity_.begin(pair);
    if (sequence.isIgnored()) return std::nullopt;
    Output output;
    if (sequence.startsAnew()) output.event = sequence.reason;
    try {
      processBegun(pair, output);
    } catch (...) {
      // Some processors have this frame, others do not: only a new start makes them agree.
      reset();
      throw;
    }
    return output;
  }

 private:
  void processBegun(const StereoPair& pair, Output& output) {
    Stopwatch total;
    output.disparity = disparity_.process(
        {[&](const Past& past) { return followCamera(pair, past.stamp(), output); },
         [&](Stamp) { return movedMask(*moving_mask_, *pair.left); },
         {},
         column_offset_});
    column_offset_ = output.ego_motion.estimate.column_offset;
    output.times.insert(output.times.end(), disparity_.times().begin(), disparity_.times().end());

    Stopwatch watch;
    const PoseAnswer answer =
        cameraPose(tf_, &odometry_, pair.left->header.frame_id, moving_objects_.lastWithPose(),
                   pair.left->header.stamp, params_.moving_objects.odom_frame);
    output.moving_objects = moving_objects_.process(output.disparity, answer.value);
    moving_mask_ = output.moving_objects.mask;
    output.clouds = {output.disparity.disparity, pair.left, output.disparity.rig,
                     params_.disparity.points, moving_mask_};
    watch.lap("detection", output.times);
    total.lap("whole frame", output.times);
  }

  // Runs the ego-motion, and gets the motion since the past frame from tf and the odometry.
  std::optional<CameraMotion> followCamera(const StereoPair& pair, std::optional<Stamp> past,
                                           Output& output) {
    const std_msgs::Header& header = pair.left->header;
    Stopwatch watch;
    std::string error;
    const auto T_base_cam = ego_motion_.extrinsic(tf_, pair, error);
    if (!T_base_cam)
      throw std::invalid_argument("no transform from base_frame '" + ego_motion_.baseFrame(pair) +
                                  "' to the left camera: " + error);
    const bool masked = params_.ego_motion.use_moving_mask && moving_mask_;
    output.ego_motion = ego_motion_.process(
        pair, *T_base_cam, masked ? movedMask(*moving_mask_, *pair.left) : cv::Mat1b());
    watch.lap("ego-motion", output.times);
    if (params_.ego_motion.publish_tf) tf_.setTransform(output.ego_motion.transform, "ego_motion");
    odometry_.add(output.ego_motion.odometry);
    if (!past) return std::nullopt;
    const MotionAnswer answer = cameraMotion(tf_, &odometry_, header.frame_id, rosTime(*past),
                                             header.stamp, params_.disparity.odom_frame);
    if (!answer.value) output.event = answer.reason + ": matched without prediction";
    return answer.value;
  }

  void reset() {
    ego_motion_.reset();
    disparity_.reset();
    moving_objects_.reset();
    odometry_.clear();
    column_offset_ = ColumnOffset();
    moving_mask_.reset();
  }

  AllNodeletParams params_;
  tf2::BufferCore& tf_;
  OdometryHistory odometry_;
  EgoMotionProcessor ego_motion_;
  DisparityProcessor disparity_;
  MovingObjectsProcessor moving_objects_;
  ColumnOffset column_offset_;         // after the previous frame
  sensor_msgs::ImagePtr moving_mask_;  // of the previous frame
};

/// Calls `visit(topic, make)` for each output of the nodelets; make(PipelineProcessor::Output) is a
/// pointer to its message.
template <class Visit>
void visitOutputs(const Visit& visit) {
  using O = PipelineProcessor::Output;
  // @param part  member that has what the outputs of a nodelet are made of.
  const auto of = [&visit](auto part) {
    return [&visit, part](const OutputTopic& topic, const auto& make) {
      visit(topic.name, [&](const O& frame) { return std::invoke(make, frame.*part); });
    };
  };
  visitEgoMotionOutputs(of(&O::ego_motion));
  visitDisparityOutputs(of(&O::disparity), of(&O::disparity));
  visitCloudOutputs(of(&O::clouds));
  visitMovingObjectsOutputs(of(&O::moving_objects));
}

}  // namespace predictive_stereo
