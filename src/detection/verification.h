#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "detection/frame_history.h"
#include "detection/observation.h"
#include "detection/point_tracks.h"
#include "detection/segmentation.h"
#include "parallel/tasks.h"

namespace predictive_stereo {

/// A hypothesis that was verified.
struct VerifiedObject {
  Observation object;
  Hypothesis hypothesis;
  Segment segment;
};

/// Verifies the hypotheses of a frame, and collects the objects: of plausible size, with a foot on
/// the ground, each object once.
class Verification {
 public:
  /// Forgets the objects of the last frame.
  void forgetObjects() { objects_.clear(); }
  /// Starts a frame in which objects are sought.
  /// @param residual_px  see longResidual; shared, not copied.
  void setFrame(const FrameView& frame, const cv::Mat1f& residual_px);
  const std::vector<Observation>& objects() const { return objects_; }

  /// Whether a found object has this lattice point.
  bool isTaken(cv::Point lattice_point) const { return taken_(lattice_point) != 0; }
  /// Whether most of its seeds are outside the objects found so far.
  bool isFree(const Hypothesis& hypothesis) const;
  /// The object, if the hypothesis is confirmed.
  /// @param static_world  see segment().
  std::optional<VerifiedObject> verify(const PastView& view, const cv::Mat1f& static_world,
                                       const Hypothesis& hypothesis) const;
  /// Calls `find` for each candidate, in parallel: it returns an optional VerifiedObject. Then adds
  /// the new ones in this order: earlier ones are preferred.
  template <class Candidates, class Find>
  void addAll(const FrameView& frame, const Candidates& candidates, const Find& find) {
    std::vector<std::optional<VerifiedObject>> verified(candidates.size());
    parallelForEach(static_cast<int>(verified.size()), [&](int i) {
      const auto k = static_cast<size_t>(i);
      verified[k] = find(candidates[k]);
    });
    for (auto& object : verified)
      if (object) add(frame, std::move(*object));
  }

 private:
  void add(const FrameView& frame, VerifiedObject&& verified);

  std::vector<Observation> objects_;
  cv::Mat1f residual_px_;
  cv::Mat1b taken_;  // lattice points of objects_
};

}  // namespace predictive_stereo
