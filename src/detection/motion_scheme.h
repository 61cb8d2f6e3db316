/// The default detector: tracks and dense residuals against the static world.
#pragma once

#include <vector>

#include "detection/dense_channel.h"
#include "detection/frame_comparison.h"
#include "detection/point_tracks.h"
#include "detection/road_line.h"
#include "detection/segmentation.h"
#include "detection/suspicion.h"
#include "detection/tracker.h"

namespace predictive_stereo {

/// An object of this frame with its pixels.
struct ObservedObject {
  Observation observation;
  cv::Mat1b mask;  ///< 255 on its pixels; of the size of its box
};

class MotionScheme {
 public:
  MotionScheme(const DisparityRange& range, const MotionDetectionParams& params)
      : range_(range), params_(params) {}
  /// The previous frame is kept.
  void setParams(const MotionDetectionParams& params) { params_ = params; }

  /// @param known  objects that are followed, moved to this frame.
  void observe(const DetectionInput& input, const ObjectTracker& known,
               std::vector<ObservedObject>& objects);
  void reset() { previous_ = RememberedFrame(), road_.reset(); }

 private:
  void setLayer(const DetectionInput& input, Hypothesis& hypothesis) const;
  void remember(const DetectionInput& input);
  void tryHypothesis(const DetectionInput& input, const Hypothesis& hypothesis,
                     const Eigen::Matrix3d& covariance, bool dense, bool expected,
                     std::vector<ObservedObject>& objects);

  DisparityRange range_;
  MotionDetectionParams params_;
  RememberedFrame previous_, current_;

  // The frame in work.
  Eigen::Isometry3d T_prev_cam_ = Eigen::Isometry3d::Identity();
  Comparison static_world_;
  Suspicion suspicion_;
  DenseGroups dense_groups_;
  std::optional<RoadLine> road_;  // the last one that was found
  LevelGround ground_;
  SegmentationWork segmentation_;
  cv::Mat1f dense_residual_px_;
  cv::Mat1b taken_;  // lattice points of objects that were found already
};

}  // namespace predictive_stereo
