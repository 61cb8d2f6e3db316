/// The disparity of a stereo sequence, each frame predicted from the past.
#pragma once

#include <functional>
#include <optional>

#include "predictive_stereo/disparity_estimator.h"
#include "predictive_stereo/ego_motion.h"
#include "predictive_stereo/past.h"
#include "predictive_stereo/stereo_frame.h"

namespace predictive_stereo {

/// Disparities are matched with the right camera's cx corrected by the column offset
/// (correct_columns). The corrected rig goes with the frame: who keeps disparities of earlier
/// frames (Past, MovingObjectDetector) compares it with the rig before.
class DisparityLoop {
 public:
  /// Returns the camera's motion since the past; nullopt: not known. It may wait.
  using Motion = std::function<std::optional<CameraMotion>(Past&)>;
  /// Returns the mask of moving objects of this earlier frame: 255 on them, 0 elsewhere, of
  /// rig.size; empty: not known. It may wait.
  using Moved = std::function<cv::Mat1b(Stamp)>;

  /// @param max_gap_s  [s] a longer gap between two frames breaks the sequence.
  /// @throws std::invalid_argument as DisparityEstimator does.
  DisparityLoop(const DisparityParams& params, double max_gap_s);

  /// Takes a frame. If it does not continue the previous one, all earlier frames are forgotten.
  /// If the result says isIgnored(), measure() must not be called.
  /// @throws std::invalid_argument if an image does not have rig.size; the state is then unchanged.
  SequenceGuard::Result begin(const StereoFrame& frame);
  /// All maps but the published ones, of the frame that begin() took.
  /// @param motion  called once, while the images are matched at half resolution.
  /// @param moved  called only if the mask is needed; may be empty.
  /// @throws std::invalid_argument if a mask does not have rig.size, if images are smaller than 2x2
  ///   pixels, or for what DisparityEstimator::begin refuses; and whatever the functions throw.
  void measure(const Motion& motion, const Moved& moved, DisparityOutput& maps);
  /// The published maps.
  void publish(DisparityOutput& maps) { estimator_.publish(past_.current(), maps); }

  /// begin(), measure() and publish() in one call.
  /// @returns false for a duplicate; `maps` are then unchanged.
  bool process(const StereoFrame& frame, const Motion& motion, DisparityOutput& maps) {
    if (begin(frame).isIgnored()) return false;
    measure(motion, {}, maps);
    publish(maps);
    return true;
  }

  /// Moving objects of the last frame are no part of the past, if use_moving_mask.
  /// @throws std::invalid_argument as Past::eraseMoving does.
  void eraseMoving(const cv::Mat1b& mask);
  /// The column offset that ego-motion has estimated, for the following frames.
  void setColumnOffset(const ColumnOffset& offset) { next_offset_ = offset; }

  /// Sets parameters for the next frame. The past is kept, unless the disparity range changes.
  /// @throws std::invalid_argument as the constructor does; the parameters are then unchanged.
  void setParams(const DisparityParams& params);
  void reset();

  /// The column offset of this frame, and its rig, corrected by it.
  const ColumnOffset& columnOffset() const { return offset_; }
  const StereoRig& rig() const { return rig_; }
  const Past& past() const { return past_; }
  const DisparityEstimator& estimator() const { return estimator_; }
  /// Of the last frame.
  const StageTimes& times() const { return estimator_.times(); }

 private:
  void correctColumns();

  DisparityParams params_;
  DisparityEstimator estimator_;
  SequenceGuard guard_;
  StereoFrame frame_;  // that begin() took
  StereoRig rig_;      // its rig, with cx_right_px corrected
  ColumnOffset offset_, next_offset_;
  Past past_;
};

}  // namespace predictive_stereo
