/// The method on one stereo sequence: ego-motion, disparity with variance, moving objects.
#pragma once

#include <functional>

#include "predictive_stereo/disparity_loop.h"
#include "predictive_stereo/moving_objects.h"
#include "predictive_stereo/visual_odometry.h"

namespace predictive_stereo {

struct PipelineParams {
  double max_gap = 1.0;  ///< [s] a longer gap between two frames breaks the sequence
  EgoMotionParams ego_motion;
  DisparityParams disparity;
  DetectionParams detection;  ///< its range is overwritten by disparity/matcher/range

  template <class Visitor>
  void visit(Visitor&& v) {
    v("max_gap", max_gap, 0.01, 3600.0);
    v("ego_motion", ego_motion);
    v("disparity", disparity);
    v("detection", detection);
  }
};

struct PipelineOutput : OdometryOutput {
  /// The column offset that this frame was matched with; correction_px was added to its
  /// disparities.
  ColumnOffset column_offset;
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

/// The paper's Fig. 1 in one process, without ROS: VisualOdometry, DisparityLoop and
/// MovingObjectDetector on the same frames. Each of them keeps its own state.
class Pipeline {
 public:
  /// Follows the camera to the frame that begin() took.
  using Follow = std::function<OdometryOutput()>;

  /// @throws std::invalid_argument if a parameter is outside its limits, or for what the
  ///   constructors of the parts refuse.
  explicit Pipeline(const PipelineParams& params);

  /// Takes a frame. If it does not continue the previous one (time went back, a gap, another
  /// calibration), all earlier frames are forgotten; see VisualOdometry::begin.
  /// If the result says isIgnored(), process() must not be called.
  /// @throws std::invalid_argument if an image does not have rig.size; the state is then unchanged.
  SequenceGuard::Result begin(const StereoFrame& frame);
  /// Processes the frame that begin() took. Buffers of `output` are reused.
  /// @param follow  called once: the pipeline's own odometry, or poses from elsewhere.
  /// @throws std::invalid_argument as DisparityLoop::measure does; and whatever `follow` throws.
  void process(const Follow& follow, PipelineOutput& output);

  /// begin() and process() in one call.
  /// @returns false for a duplicate or a late frame; `output` is then unchanged.
  bool process(const StereoFrame& frame, const Follow& follow, PipelineOutput& output) {
    if (begin(frame).isIgnored()) return false;
    process(follow, output);
    return true;
  }
  bool process(const StereoFrame& frame, PipelineOutput& output) {
    return process(
        frame, [this] { return odometry_.follow(); }, output);
  }

  /// Forgets everything: the poses start with the next frame.
  void reset();

  /// Sets parameters of a part for the next frame. The past is kept, unless the disparity range
  /// changes.
  /// @throws std::invalid_argument as the part's constructor does; the parameters are then
  ///   unchanged.
  void setParams(const EgoMotionParams& params) { odometry_.setParams(params); }
  void setParams(const DisparityParams& params);
  void setParams(const DetectionParams& params);

  const DisparityLoop& disparity() const { return disparity_; }
  /// Stage times of the last frame.
  const PipelineTimes& times() const { return times_; }

 private:
  void detect(PipelineOutput& output);

  VisualOdometry odometry_;
  DisparityLoop disparity_;
  DetectionParams detection_params_;
  MovingObjectDetector detector_;
  StereoFrame frame_;  // that begin() took
  PipelineTimes times_;
};

}  // namespace predictive_stereo
