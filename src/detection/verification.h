#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "detection/frame_view.h"
#include "detection/ground.h"
#include "detection/hypothesis.h"
#include "detection/road_line.h"
#include "detection/segmentation.h"
#include "detection/tracker.h"
#include "parallel/work_pool.h"

namespace predictive_stereo {

/// What a hypothesis turned out to be.
struct VerifiedObject {
  ObservedObject object;
  Hypothesis hypothesis;
  Segment segment;
};

/// Memory that is used again from hypothesis to hypothesis.
struct VerificationWork {
  SegmentationWork segmentation;
  Comparison static_world;  // of one hypothesis, for those who need it
};

/// Verifies hypotheses of a frame, and keeps what they turn out to be: objects with sizes that road
/// users have and a foot on the road, each of them once.
class Verification {
 public:
  /// What is seen of the road, and of level ground. They need nothing of each other.
  void findRoad(const DetectionInput& input, const DisparityRange& range);
  void findGround(const DetectionInput& input, const DisparityRange& range);
  /// After both. Objects of the frame before are forgotten.
  /// @param residual_px  see longResidual; shared, not copied.
  void setFrame(const FrameView& frame, const cv::Mat1f& residual_px);
  const LevelGround& ground() const { return ground_; }
  const std::vector<ObservedObject>& objects() const { return objects_; }

  /// Whether most of it is no part of an object that was found already.
  bool isFree(const Hypothesis& hypothesis) const;
  /// The object that it turns out to be, if it is one.
  std::optional<VerifiedObject> verify(const FrameView& frame, const Baseline& baseline,
                                       const Hypothesis& hypothesis, VerificationWork& work) const;

  using Finder = std::function<std::optional<VerifiedObject>(int, VerificationWork&)>;
  /// Asks for candidates 0 ... count - 1, in parallel, and then adds those that are new in this
  /// order, so that earlier ones are preferred.
  /// @return of each candidate whether it was added.
  std::vector<bool> addAll(const FrameView& frame, int count, const Finder& find);
  void forgetObjects() { objects_.clear(); }
  void reset() { road_.reset(); }

 private:
  bool add(const FrameView& frame, VerifiedObject&& verified);

  LevelGround ground_;
  std::optional<RoadLine> road_;  // the last one that was found
  WorkPool<VerificationWork> works_;
  std::vector<ObservedObject> objects_;
  cv::Mat1f residual_px_;
  cv::Mat1b taken_;  // lattice points of objects_
};

}  // namespace predictive_stereo
