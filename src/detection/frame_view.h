#pragma once

#include "detection/depth_cells.h"
#include "detection/frame_comparison.h"
#include "detection/frame_history.h"
#include "detection/ground_plane.h"
#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/moving_objects.h"

namespace predictive_stereo {

struct PastView;

/// The current frame, for all parts of the detector.
struct FrameView {
  const DetectionInput& input;
  const DisparityRange& range;
  const MotionDetectionParams& params;
  const RememberedFrame& current;
  const DepthCells& cells;
  const std::optional<GroundPlane>& ground;  ///< none: this frame shows none

  cv::Size lattice() const { return current.pyramid.level(1).size(); }
  /// @param past  must outlive the view, as this frame must.
  PastView since(const PastFrame& past) const;
};

/// The current frame, and a past one that it is compared with.
struct PastView {
  const FrameView& frame;
  const PastFrame& past;
  SourceOf static_source;  ///< where static points were

  const StereoRig& rig() const { return frame.input.rig; }
  const MotionDetectionParams& params() const { return frame.params; }
  const cv::Mat1f& disparity_px() const { return frame.input.measured_disparity_px; }
  bool isKnown(float disparity_px) const { return frame.range.isValid(disparity_px); }
  const ImagePyramid& images() const { return frame.current.pyramid; }
  const ImagePyramid& past_images() const { return past.frame->pyramid; }
  /// See compareFrames.
  void compare(const SourceOf& source_of, const cv::Rect& area, Comparison& comparison) const {
    compareFrames(images(), disparity_px(), frame.range, past_images(), source_of, area,
                  comparison);
  }
};

inline PastView FrameView::since(const PastFrame& past) const {
  return {*this, past, SourceOf(disparityMotion(input.rig, past.T_past_cam))};
}

}  // namespace predictive_stereo
