/// The past of the disparity loop: what the next frame is predicted from.
#pragma once

#include <optional>

#include "predictive_stereo/disparity_motion.h"
#include "predictive_stereo/prediction.h"
#include "predictive_stereo/sequence_guard.h"

namespace predictive_stereo {

/// Decides what the past is. It is the last frame whose filters were kept. A frame is predicted
/// from it if the camera's motion since then is known. A frame without such a motion (unlinked) is
/// matched without prediction and does not change the past, so only this frame suffers. The past is
/// forgotten after max_missed_frames unlinked frames, or if no motion can lead from it to a later
/// frame. Moving objects are not part of it: see kMovesByItself.
class Past {
 public:
  /// Sets the rig of this frame. Disparities of the past are corrected by the change of cx_right:
  /// it is the only change that continues a sequence.
  void setRig(const DisparityRange& range, const StereoRig& rig);

  /// The frame; nullopt: there is none.
  std::optional<Stamp> stamp() const { return stamp_; }
  /// Its filters; empty if there is none.
  const DisparityState& filters() const { return filters_; }

  /// The motion since the past, if this ego-motion starts there. If it starts elsewhere, the past
  /// is forgotten: later motions start from later frames, never from the past.
  /// @param start  nullopt: the motion was not seen.
  std::optional<CameraMotion> motionBy(const CameraMotion& motion, std::optional<Stamp> start);

  /// Chooses the filters that this frame writes: those of the past, or those of an unlinked frame.
  void link(bool motion_known, int max_missed_frames);
  DisparityState& current() { return is_linked_ ? filters_ : unlinked_; }
  /// This frame's filters are complete: it is the past now, unless it is unlinked.
  void carry(Stamp stamp);

  /// Whether the last frame is the past, so that its moving objects must be erased.
  bool isLastFrame() const { return stamp_ && unlinked_frames_ == 0; }
  /// @param mask  of the last frame: 255 on moving objects; empty: none.
  /// @throws std::invalid_argument if it does not have the size of the filters.
  void eraseMoving(const cv::Mat1b& mask);

  void forget();

 private:
  StereoRig rig_;
  DisparityState filters_;
  std::optional<Stamp> stamp_;
  int unlinked_frames_ = 0;  // since then
  DisparityState unlinked_;  // the filters of an unlinked frame, which are discarded
  bool is_linked_ = true;    // whether the current frame writes filters_
};

}  // namespace predictive_stereo
