#pragma once

#include <tf2/buffer_core.h>

#include <optional>
#include <string>

#include "nodelets/disparity_processor.h"
#include "nodelets/ego_motion_processor.h"
#include "nodelets/moving_objects_processor.h"
#include "nodelets/nodelet_params.h"
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
    std::string event;  ///< why this frame starts a new sequence or has no prediction; else empty
    StageTimes times;
  };

  explicit PipelineProcessor(const AllNodeletParams& params);

  /// The caller adds transforms of other publishers: base_frame -> camera, and the camera's motion
  /// if EgoMotion does not publish it.
  tf2::BufferCore& tf() { return tf_; }

  /// That of the disparity, see simd_target.h; empty: no warning.
  std::string slowTargetWarning() const { return disparity_.slowTargetWarning(); }

  /// @returns none if the pair has the stamp of the previous one.
  /// @throws std::invalid_argument for a pair that cannot be used: the state stays as it was; or if
  ///   tf lacks base_frame -> camera: the next pair is the first one then.
  std::optional<Output> process(const StereoPair& pair);

 private:
  Output processBegun(const StereoPair& pair, const SequenceGuard::Result& sequence);
  void reset();
  Eigen::Isometry3d extrinsic(const StereoPair& pair) const;
  std::optional<CameraMotion> followCamera(const StereoPair& pair, std::optional<Stamp> past,
                                           Output& output);

  AllNodeletParams params_;
  tf2::BufferCore tf_;
  OdometryHistory odometry_;
  EgoMotionProcessor ego_motion_;
  DisparityProcessor disparity_;
  MovingObjectsProcessor moving_objects_;
  ColumnOffset column_offset_;         // after the previous frame
  sensor_msgs::ImagePtr moving_mask_;  // of the previous frame
};

}  // namespace predictive_stereo
