#pragma once

#include <tf2/buffer_core.h>

#include <optional>
#include <string>

#include "nodelets/disparity_processor.h"
#include "nodelets/ego_motion_processor.h"
#include "nodelets/motion_source.h"
#include "nodelets/moving_objects_processor.h"
#include "nodelets/nodelet_params.h"
#include "predictive_stereo/stage_times.h"

namespace predictive_stereo {

/// The three processors, joined as the nodelets are: Disparity asks for the motion, by tf and the
/// odometry message, and for the mask of moving objects. So its results are theirs, bit by bit.
class PipelineProcessor {
 public:
  struct Output {
    EgoMotionMessages ego_motion;
    EgoMotionEstimate estimate;
    DisparityMessages disparity;
    MovingObjectsMessages moving_objects;
    std::optional<Eigen::Isometry3d> T_odom_cam;  ///< as tf has it
    std::string event;  ///< why this frame starts anew or has no prediction; empty: it goes on
    StageTimes times;
  };

  explicit PipelineProcessor(const AllNodeletParams& params);

  /// To be filled with what tf knows from elsewhere: the extrinsic from base_frame to the camera,
  /// and the camera's motion where EgoMotion does not publish it.
  tf2::BufferCore& tf() { return tf_; }

  /// Of the disparity; see simd_target.h. Empty where all is well.
  std::string slowTargetWarning() const { return disparity_.slowTargetWarning(); }

  /// @returns none where the pair has the stamp of the one before.
  /// @throws std::invalid_argument for a pair that cannot be used, or without an extrinsic.
  std::optional<Output> process(const StereoPair& pair);

 private:
  Eigen::Isometry3d extrinsic(const StereoPair& pair) const;
  std::optional<CameraMotion> followCamera(const StereoPair& pair, std::optional<ros::Time> past,
                                           Output& output);

  AllNodeletParams params_;
  tf2::BufferCore tf_;
  OdometryHistory odometry_;
  EgoMotionProcessor ego_motion_;
  DisparityProcessor disparity_;
  MovingObjectsProcessor moving_objects_;
  ColumnOffset column_offset_;         // after the frame before
  sensor_msgs::ImagePtr moving_mask_;  // of the frame before
};

}  // namespace predictive_stereo
