/// Processes one stereo pair after the other: ego-motion, disparity with variance, moving objects.
/// Keeps the state that the next frame needs.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "predictive_stereo/camera_path.h"
#include "predictive_stereo/disparity_estimator.h"
#include "predictive_stereo/ego_motion.h"
#include "predictive_stereo/moving_objects.h"
#include "predictive_stereo/sequence_guard.h"

namespace predictive_stereo {

/// The parts that a pipeline runs. The results of the others may come from elsewhere, see
/// FrameSources.
struct PipelineParts {
  bool ego_motion = true;
  bool disparity = true;
  bool detection = true;
};

struct PipelineParams {
  PipelineParts parts;   ///< set by the program, not by its users
  double max_gap = 1.0;  ///< [s] a longer gap between two frames breaks the sequence
  EgoMotionParams ego_motion;
  DisparityParams disparity;
  DetectionParams detection;  ///< its range is overwritten by disparity/matcher/range if both run

  template <class Visitor>
  void visit(Visitor&& v) {
    v("max_gap", max_gap, 0.01, 3600.0);
    v("ego_motion", ego_motion);
    v("disparity", disparity);
    v("detection", detection);
  }
};

/// One stereo pair.
struct StereoFrame {
  /// Rectified 8-bit grey images of rig.size. They must stay alive and unchanged until process() is
  /// done. Detection alone does not need `right`.
  cv::Mat1b left, right;
  StereoRig rig;
  Stamp stamp{};
};

/// Inputs of one frame from outside the pipeline. What is not set, the pipeline takes from its own
/// parts. process() calls the functions in its thread; they may wait.
struct FrameSources {
  /// Not 0 where ego-motion ignores features of the previous frame. Not used if not of rig.size.
  cv::Mat1b ignored;
  /// For ego-motion: rotation since the previous frame from another sensor, see
  /// EgoMotion::estimate.
  std::optional<Eigen::Matrix3d> R_cam_prev;
  /// Pose of the left camera's optical frame in the body whose path PoseEstimate describes, e.g. a
  /// robot's base.
  Eigen::Isometry3d T_body_cam = Eigen::Isometry3d::Identity();
  /// Ego-motion that another pipeline estimated on the same frames.
  std::optional<EgoMotionEstimate> ego_motion;
  /// Column offset that an ego-motion elsewhere had estimated after the previous frame.
  std::optional<ColumnOffset> column_offset;
  /// Returns the camera's motion from the frame `past` to this one; nullopt: not known. Called once
  /// per frame; without a past (nullopt) its result is not used.
  std::function<std::optional<CameraMotion>(std::optional<Stamp> past)> motion;
  /// Returns the mask of moving objects of the previous frame, whose stamp is `previous`: 255 on
  /// them, 0 elsewhere, of rig.size; empty: not known. Called only if it is needed.
  std::function<cv::Mat1b(Stamp previous)> moved;
  /// For the detection, if no ego-motion is known here.
  std::optional<CameraPose> pose;
  /// Called as soon as the measured and predicted maps are complete, which detection needs.
  std::function<void()> measured;
};

struct PipelineOutput {
  EgoMotionEstimate ego_motion;
  /// The frame that ego_motion.motion starts from; nullopt: it was not seen.
  std::optional<Stamp> motion_start;
  /// The column offset that this frame was matched with; correction_px was added to its
  /// disparities.
  ColumnOffset column_offset;
  /// The pose of this frame; without ego-motion that of FrameSources::pose, with a covariance
  /// of zero.
  PoseEstimate pose;
  /// If disparities are estimated elsewhere, the caller sets the maps that detection needs.
  DisparityOutput disparity;
  Detections detections;
};

/// Duration of the stages of one frame, by part. Some run at the same time, so their sum is larger
/// than the time of the frame.
struct PipelineTimes {
  StageTimes ego_motion, disparity, detection;
  /// All of them, in that order.
  StageTimes all() const;
};

/// The whole method of the paper's Fig. 1 on one stereo sequence, without ROS. All state that
/// passes from frame to frame is here or in the parts.
///
/// The past is the last frame whose filters were kept. A frame is predicted from it if the camera's
/// motion since then is known. A frame without such a motion (unlinked) is matched without
/// prediction and does not change the past, so only this frame suffers. The past is forgotten after
/// correction/max_missed_frames unlinked frames, or if no motion can lead from it to a later frame.
/// Moving objects are not part of the past: if disparity/use_moving_mask, their disparities are not
/// used for the next frame's search ranges and filters, see kMovesByItself.
///
/// Disparities are matched with the right camera's cx corrected by the column offset that
/// ego-motion had estimated after the previous frame (disparity/correct_columns). When the
/// correction changes, the disparities of the past are corrected too, also those in the detector.
class Pipeline {
 public:
  /// @throws std::invalid_argument if a parameter is outside its limits, or for what the
  ///   constructors of EgoMotion, DisparityEstimator and MovingObjectDetector refuse.
  explicit Pipeline(const PipelineParams& params);
  ~Pipeline();

  /// Takes a frame. If it does not continue the previous one (time went back, a gap, another
  /// calibration), all earlier frames are forgotten. The pose goes on over a gap, see CameraPath.
  /// If time went back, it starts at the origin again.
  /// @returns kDuplicate if the frame must be ignored: process() must not be called then.
  /// @throws std::invalid_argument if an image does not have rig.size; the state is then unchanged.
  SequenceGuard::Result begin(const StereoFrame& frame);
  /// Runs all parts on the frame that begin() took. Buffers of `output` are reused.
  /// @throws std::invalid_argument if the mask that sources.moved returns or a map that the caller
  ///   set in output.disparity does not have rig.size, if images to match are smaller than 2x2
  ///   pixels, or for what DisparityEstimator::begin refuses; and whatever the functions of
  ///   `sources` throw.
  void process(const FrameSources& sources, PipelineOutput& output);

  /// begin() and process() in one call.
  /// @returns false for a duplicate; `output` is then unchanged.
  /// @throws as begin() and process() do.
  bool process(const StereoFrame& frame, PipelineOutput& output, const FrameSources& sources = {}) {
    if (begin(frame).verdict == SequenceGuard::Verdict::kDuplicate) return false;
    process(sources, output);
    return true;
  }

  /// Whether the poses start with the frame that begin() took.
  bool isOrigin() const { return path_.empty(); }
  /// Pose of the body in the frame that the poses start with; without this call it is identity.
  void setOrigin(const Eigen::Isometry3d& T_odom_body) { path_.setOrigin(T_odom_body); }
  /// Forgets everything: the poses start with the next frame.
  void reset();

  /// Sets parameters of a part for the next frame. The pipeline must run that part. The past is
  /// kept, unless the disparity range changes.
  /// @throws std::invalid_argument as the part's constructor does; the parameters are then
  ///   unchanged.
  void setParams(const EgoMotionParams& params);
  void setParams(const DisparityParams& params);
  void setParams(const DetectionParams& params);

  /// The stamp of the frame that the next one is predicted from.
  std::optional<Stamp> past() const { return past_stamp_; }
  /// The filters of that frame; empty without a past.
  const DisparityState& pastFilters() const { return past_; }
  /// The disparity part, which the pipeline must run.
  const DisparityEstimator& disparity() const { return *disparity_; }
  /// Stage times of the last frame.
  const PipelineTimes& times() const { return times_; }

 private:
  void correctColumns(const FrameSources& sources, PipelineOutput& output);
  void followCamera(const FrameSources& sources, PipelineOutput& output);
  std::optional<CameraMotion> motionFromPast(const FrameSources& sources,
                                             const PipelineOutput& output);
  DisparityState& linkToPast(bool motion_known);
  void detect(PipelineOutput& output);
  bool needsMovingMask() const;
  void markMoving(const cv::Mat1b& mask);
  void startAnew();
  void forgetFrames();
  void forgetPast();

  PipelineParams params_;
  std::optional<EgoMotion> ego_motion_;
  std::optional<DisparityEstimator> disparity_;
  std::optional<MovingObjectDetector> detector_;
  SequenceGuard guard_;
  StereoFrame frame_;  // that begin() took
  StereoRig rig_;      // its rig, with cx_right_px corrected
  PipelineTimes times_;

  // State for the next frame, in addition to the state of the parts.
  CameraPath path_;
  ColumnOffset column_offset_;
  bool has_previous_ = false;  // whether the frame follows another one
  DisparityState past_;        // the filters of the frame with past_stamp_
  std::optional<Stamp> past_stamp_;
  int unlinked_frames_ = 0;  // since then
  DisparityState unlinked_;  // the filters of an unlinked frame, which are discarded
};

}  // namespace predictive_stereo
