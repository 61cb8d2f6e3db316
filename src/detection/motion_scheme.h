/// The default detection scheme: compares images and disparities with those of a static world.
#pragma once

#include <optional>
#include <vector>

#include "detection/across_channel.h"
#include "detection/along_channel.h"
#include "detection/frame_history.h"
#include "detection/free_space_channel.h"
#include "detection/tracker.h"
#include "detection/verification.h"

namespace predictive_stereo {

class MotionScheme {
 public:
  MotionScheme(const DisparityRange& range, const MotionDetectionParams& params)
      : range_(range), params_(params) {}
  /// Keeps the past frames.
  void setParams(const MotionDetectionParams& params) { params_ = params; }

  /// See FrameHistory.
  bool isShownAgain(const DetectionInput& input) const { return frames_.isShownAgain(input); }
  /// @param camera_pixel_px  see Rescaling.
  /// @param known  tracks, predicted to this frame.
  /// @returns the objects of this frame; valid until the next call.
  const std::vector<Observation>& observe(const DetectionInput& input, float camera_pixel_px,
                                          const ObjectTracker& known);
  /// Whether the known objects were sought in this frame: not without a pose, nor in the first
  /// frame after that, nor with a wrong one.
  bool soughtKnown() const { return sought_known_; }
  /// See FrameHistory.
  void addToDisparities(double step_px) {
    frames_.addToDisparities(range_, step_px);
    free_space_.addToDisparities(step_px);
  }
  void reset();

 private:
  void findByMotion(const FrameView& frame, const std::vector<PastFrame>& past,
                    const std::optional<PastFrame>& other, const ObjectTracker& known);
  void addMoving(const FrameView& frame, const std::vector<Observation>& moving);

  DisparityRange range_;
  MotionDetectionParams params_;
  FrameHistory frames_;
  PoseCheck pose_check_;

  // Of the current frame.
  DepthCells cells_;
  SteadyGround ground_;
  Obstacles obstacles_;
  cv::Mat1f texture_;
  AcrossChannel since_last_, since_other_;  // compare with the last frame, and another one
  AlongChannel along_;
  FreeSpaceChannel free_space_;
  Verification verification_;
  std::vector<Observation> objects_;
  bool sought_known_ = false;
};

}  // namespace predictive_stereo
