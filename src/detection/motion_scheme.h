/// The default detector: tracks and dense residuals against the static world.
#pragma once

#include <vector>

#include "detection/dense_channel.h"
#include "detection/frame_history.h"
#include "detection/frame_view.h"
#include "detection/pose_check.h"
#include "detection/slow_channel.h"
#include "detection/suspicion.h"
#include "detection/tracker.h"
#include "detection/verification.h"

namespace predictive_stereo {

class MotionScheme {
 public:
  MotionScheme(const DisparityRange& range, const MotionDetectionParams& params)
      : range_(range), params_(params) {}
  /// The previous frame is kept.
  void setParams(const MotionDetectionParams& params) { params_ = params; }

  /// @param known  objects that are followed, moved to this frame.
  /// @return valid until the next call.
  const std::vector<ObservedObject>& observe(const DetectionInput& input,
                                             const ObjectTracker& known);
  /// See FrameHistory.
  void addToDisparities(double step_px) { frames_.addToDisparities(range_, step_px); }
  void reset();

 private:
  Baseline baseline() const { return {past_, static_world_, residual_px_}; }
  const std::vector<cv::Point>& compare(const FrameView& frame);
  void findAcross(const FrameView& frame, const std::vector<cv::Point>& suspects_px);
  void findAlong(const FrameView& frame);
  void findKnown(const FrameView& frame, const ObjectTracker& known);

  DisparityRange range_;
  MotionDetectionParams params_;
  FrameHistory frames_;
  PoseCheck pose_check_;

  // The frame in work.
  PastFrame past_;  // the last one
  Comparison static_world_;
  cv::Mat1f residual_px_;
  Suspicion suspicion_;
  std::vector<cv::Point> unexplained_px_;
  DenseGroups along_groups_;
  SlowChannel slow_;
  Verification verification_;
};

}  // namespace predictive_stereo
