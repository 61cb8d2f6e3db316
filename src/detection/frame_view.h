#pragma once

#include "detection/frame_comparison.h"
#include "detection/frame_history.h"
#include "detection/point_tracks.h"
#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/moving_objects.h"

namespace predictive_stereo {

/// The current frame, for all parts of the detector.
struct FrameView {
  const DetectionInput& input;
  const DisparityRange& range;
  const MotionDetectionParams& params;
  const RememberedFrame& current;

  cv::Size lattice() const { return current.pyramid.level(1).size(); }
  SourceOf staticSource(const PastFrame& past) const {
    return SourceOf(disparityMotion(input.rig, past.T_past_cam));
  }
  TrackingView trackingInto(const PastFrame& past) const {
    return {input.rig,
            range,
            current.pyramid,
            input.measured_disparity_px,
            input.measured_variance_px2,
            *past.frame,
            past.T_past_cam,
            past.motion_covariance};
  }
};

/// A past frame, and the comparison of the current frame with it.
struct Baseline {
  const PastFrame& past;
  const Comparison& static_world;  ///< of the whole lattice, or of the reach of a hypothesis
};

}  // namespace predictive_stereo
