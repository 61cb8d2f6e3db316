/// The life of a frame: one stereo pair in; ego-motion, disparity with variance and moving objects
/// out; and what of it the next frame starts from.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>

#include "predictive_stereo/disparity_estimator.h"
#include "predictive_stereo/ego_motion.h"
#include "predictive_stereo/moving_objects.h"
#include "predictive_stereo/sequence_guard.h"

namespace predictive_stereo {

class SecondThread;

/// The parts that a pipeline runs. The others run elsewhere, or nowhere; see FrameSources.
struct PipelineParts {
  bool ego_motion = true;
  bool disparity = true;
  bool detection = true;
};

struct PipelineParams {
  PipelineParts parts;   ///< set by the program, not by its users
  double max_gap = 1.0;  ///< [s] frames further apart do not belong together
  EgoMotionParams ego_motion;
  DisparityParams disparity;
  DetectionParams detection;  ///< where both run, its range is that of the disparities

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
  /// Rectified 8-bit grey images of rig.size, which must stay alive and unchanged until the frame
  /// is done. Detection alone needs no right one.
  cv::Mat1b left, right;
  StereoRig rig;
  Stamp stamp{};
};

/// What one frame gets from elsewhere; whatever is not set the pipeline has from its own parts.
/// Functions are called by process(), in its thread; they may wait.
struct FrameSources {
  /// 255 where the ego-motion is to ignore features of the frame before. Of another size: unused.
  cv::Mat1b ignored;
  /// For the ego-motion: what another sensor says of the rotation since the frame before. See
  /// EgoMotion::estimate.
  std::optional<Eigen::Matrix3d> R_cam_prev;
  /// Ego-motion that another pipeline estimated on the same frames.
  std::optional<EgoMotionEstimate> ego_motion;
  /// What an ego-motion elsewhere knew of the right image's columns after the frame before.
  std::optional<ColumnOffset> column_offset;
  /// The camera's motion from the frame `past` to this one; none: it is not known. Called once in
  /// each frame; without a past (nullopt) its result does not matter.
  std::function<std::optional<CameraMotion>(std::optional<Stamp> past)> motion;
  /// Mask of moving objects of the frame before, which has this stamp: 255 on them, of rig.size;
  /// empty: not known. Called only where it is needed.
  std::function<cv::Mat1b(Stamp before)> moved;
  /// Pose of the left camera's optical frame for the detection, where no ego-motion is known here.
  std::optional<Eigen::Isometry3d> T_odom_cam;
  /// Called as soon as measured and predicted maps are there, which is all that detection needs.
  std::function<void()> measured;
};

struct PipelineOutput {
  EgoMotionEstimate ego_motion;
  /// The frame that ego_motion.motion starts from; none: it was not tracked.
  std::optional<Stamp> motion_start;
  bool pose_known = false;
  /// What was known of the right image's columns when this frame was matched; correction_px is what
  /// its disparities were corrected by.
  ColumnOffset column_offset;
  /// Of the left camera's optical frame. It goes on from the origin and is held while lost.
  Eigen::Isometry3d T_odom_cam = Eigen::Isometry3d::Identity();
  /// Where disparities are estimated elsewhere, the caller puts in what the detection needs.
  DisparityOutput disparity;
  Detections detections;
};

/// Duration of the stages of one frame, by part.
struct PipelineTimes {
  StageTimes ego_motion, disparity, detection;
  StageTimes all() const;
};

/// The whole package on one stereo sequence, without ROS: the only place that knows what one frame
/// leaves for the next.
///
/// The past is the last frame whose filters were kept. A frame is predicted from it where the
/// camera's motion since then is known. A frame without such a motion (unlinked) is matched without
/// prediction and leaves the past as it is, so that it costs no more than itself; after
/// correction/max_missed_frames of them, or where no motion can ever lead from the past to a later
/// frame, the past is given up. What moved by itself is no past: where disparity/use_moving_mask,
/// its disparities do not enter the next frame's ranges and filters, see kMovesByItself.
///
/// Disparities are matched with the right camera's cx corrected by what the ego-motion knew after
/// the frame before (disparity/correct_columns). Where the correction changes, the past is
/// corrected with it, also that of the detection.
class Pipeline {
 public:
  /// @throws std::invalid_argument for parameters outside their limits.
  explicit Pipeline(const PipelineParams& params);
  ~Pipeline();

  /// Takes a frame. Where it does not go on from the one before (time went back, a gap, another
  /// calibration) everything of the frames before is forgotten, but the pose goes on: it is held
  /// over a gap, and starts anew where time went back.
  /// @returns kDuplicate where the frame is to be ignored.
  /// @throws std::invalid_argument where sizes differ from rig.size; the state stays as it was.
  SequenceGuard::Result begin(const StereoFrame& frame);
  /// Runs all parts on the frame that was taken. Buffers of `output` are used again.
  /// @throws std::invalid_argument for a mask of another size than the frame's.
  void process(const FrameSources& sources, PipelineOutput& output);

  /// Both.
  /// @returns false for a duplicate, which leaves `output` as it was.
  bool process(const StereoFrame& frame, PipelineOutput& output, const FrameSources& sources = {}) {
    if (begin(frame).verdict == SequenceGuard::Verdict::kDuplicate) return false;
    process(sources, output);
    return true;
  }

  /// Whether poses start with the frame that was taken, and from where: identity where not told.
  bool isOrigin() const { return !T_odom_cam_; }
  void setOrigin(const Eigen::Isometry3d& T_odom_cam) { T_odom_cam_ = T_odom_cam; }
  /// Forgets everything: the next frame is the origin.
  void reset();

  /// Other parameters from the next frame on. What is known of the past is kept, but disparities
  /// of another range are no past. Only of parts that this pipeline runs.
  /// @throws std::invalid_argument for what the constructor refuses; nothing has changed then.
  void setParams(const EgoMotionParams& params);
  void setParams(const DisparityParams& params);
  void setParams(const DetectionParams& params);

  /// The stamp of the frame that the next one is predicted from.
  std::optional<Stamp> past() const { return past_stamp_; }
  const DisparityState& pastFilters() const { return past_; }
  /// Only where this pipeline runs that part.
  const DisparityEstimator& disparity() const { return *disparity_; }
  /// Of the last frame.
  const PipelineTimes& times() const { return times_; }

 private:
  void correctColumns(const FrameSources& sources, PipelineOutput& output);
  void followCamera(const FrameSources& sources, PipelineOutput& output);
  std::optional<Stamp> startOf(const EgoMotionEstimate& estimate) const;
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
  StereoFrame frame_;  // in work
  StereoRig rig_;      // its rig, with corrected columns
  PipelineTimes times_;

  // State for the next frame, beside the state of the parts.
  std::optional<Eigen::Isometry3d> T_odom_cam_;
  ColumnOffset column_offset_;
  std::deque<Stamp> since_tracked_;  // the last frame that was not lost, and all after it
  DisparityState past_;              // filters, and the frame that they are of
  std::optional<Stamp> past_stamp_;
  int unlinked_frames_ = 0;  // since then
  DisparityState unlinked_;  // the filters of such a frame, which are not kept

  std::unique_ptr<SecondThread> second_thread_;
};

}  // namespace predictive_stereo
