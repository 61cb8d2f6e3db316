/// The default detector: images and disparities against the static world.
#pragma once

#include <vector>

#include "detection/across_channel.h"
#include "detection/along_channel.h"
#include "detection/frame_history.h"
#include "detection/frame_view.h"
#include "detection/pose_check.h"
#include "detection/tracker.h"
#include "detection/verification.h"

namespace predictive_stereo {

class MotionScheme {
 public:
  MotionScheme(const DisparityRange& range, const MotionDetectionParams& params)
      : range_(range), params_(params) {}
  /// The past is kept.
  void setParams(const MotionDetectionParams& params) { params_ = params; }

  /// @param known  objects that are followed, moved to this frame.
  /// @return valid until the next call.
  const std::vector<ObservedObject>& observe(const DetectionInput& input,
                                             const ObjectTracker& known);
  /// See FrameHistory.
  void addToDisparities(double step_px) { frames_.addToDisparities(range_, step_px); }
  void reset();

 private:
  void findKnown(const FrameView& frame, const ObjectTracker& known);

  DisparityRange range_;
  MotionDetectionParams params_;
  FrameHistory frames_;
  PoseCheck pose_check_;

  // The frame in work.
  AcrossChannel since_last_, since_second_last_;  // against the frame before, and the one before it
  AlongChannel along_;
  Verification verification_;
};

}  // namespace predictive_stereo
