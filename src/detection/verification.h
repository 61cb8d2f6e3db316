#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "detection/frame_view.h"
#include "detection/ground.h"
#include "detection/hypothesis.h"
#include "detection/layer_motion.h"
#include "detection/road_line.h"
#include "detection/segmentation.h"
#include "detection/tracker.h"

namespace predictive_stereo {

/// Verifies hypotheses of a frame, and keeps what they turn out to be: objects with sizes that road
/// users have and a foot on the road, each of them once.
class Verification {
 public:
  /// Finds the road. Objects of the frame before are forgotten.
  void setFrame(const FrameView& frame);
  const LevelGround& ground() const { return ground_; }
  const std::vector<ObservedObject>& objects() const { return objects_; }

  /// Whether most of it is no part of an object that was found already.
  bool isFree(const Hypothesis& hypothesis) const;
  /// Adds the object that it turns out to be, if there is one and it is new.
  /// @param history  disparities of the past, to be asked beside the images; null: not asked.
  /// @return whether there is one.
  bool add(const FrameView& frame, const Baseline& baseline, const Hypothesis& hypothesis,
           const DisparityHistory* history = nullptr);
  /// After the last one of the frame: parts of one object become one.
  void joinParts(const FrameView& frame);
  void forgetObjects() { objects_.clear(); }
  void reset() { road_.reset(); }

 private:
  bool hasPlausibleShape(const FrameView& frame, const Hypothesis& hypothesis, const cv::Rect& box,
                         double depth_m) const;

  LevelGround ground_;
  std::optional<RoadLine> road_;  // the last one that was found
  SegmentationWork segmentation_;
  std::vector<ObservedObject> objects_;
  cv::Mat1b taken_;  // lattice points of objects_
};

}  // namespace predictive_stereo
