#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "detection/frame_history.h"
#include "detection/hypothesis.h"
#include "detection/observation.h"
#include "detection/segmentation.h"
#include "parallel/work_pool.h"

namespace predictive_stereo {

/// A hypothesis that was verified.
struct VerifiedObject {
  ObservedObject object;
  Hypothesis hypothesis;
  Segment segment;
};

/// Verifies the hypotheses of a frame, and collects the objects: of plausible size, with a foot on
/// the ground, each object once.
class Verification {
 public:
  /// Finds level ground.
  void findGround(const DetectionInput& input, const DisparityRange& range);
  /// Forgets the objects of the last frame.
  void forgetObjects() { objects_.clear(); }
  /// Starts a frame in which objects are sought. Call after both of these.
  /// @param residual_px  see longResidual; shared, not copied.
  void setFrame(const FrameView& frame, const cv::Mat1f& residual_px);
  const LevelGround& ground() const { return ground_; }
  const std::vector<ObservedObject>& objects() const { return objects_; }

  /// Whether a found object has this lattice point.
  bool isTaken(cv::Point lattice_point) const { return taken_(lattice_point) != 0; }
  /// Whether most of its seeds are outside the objects found so far.
  bool isFree(const Hypothesis& hypothesis) const;
  /// The object, if the hypothesis is confirmed.
  /// @param static_world  see SegmentationMaps.
  std::optional<VerifiedObject> verify(const PastView& view, const Comparison* static_world,
                                       const Hypothesis& hypothesis, SegmentationWork& work) const;

  using Finder = std::function<std::optional<VerifiedObject>(int, SegmentationWork&)>;
  /// Calls `find` for candidates 0 ... count - 1, in parallel. Then adds the new ones in this
  /// order: earlier ones are preferred.
  void addAll(const FrameView& frame, int count, const Finder& find);

 private:
  void add(const FrameView& frame, VerifiedObject&& verified);

  LevelGround ground_;
  WorkPool<SegmentationWork> works_;
  std::vector<ObservedObject> objects_;
  cv::Mat1f residual_px_;
  cv::Mat1b taken_;  // lattice points of objects_
};

}  // namespace predictive_stereo
