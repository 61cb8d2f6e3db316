#include "detection/along_channel.h"

#include "detection/candidates.h"

namespace predictive_stereo {
namespace {

// Frames that are compared, if static points have not moved more since then.
constexpr size_t kFramesBack[] = {8, 6, 4, 2};
static_assert(kFramesBack[0] == FrameHistory::kFarthest);
constexpr double kMostParallax_px = 16;
constexpr float kLeastDisparity_px = 10;  // the relative error of smaller ones is too large

}  // namespace

void AlongChannel::compare(const FrameView& frame, const std::vector<PastFrame>& past) {
  pairs_.clear();
  for (size_t k : kFramesBack)
    if (k <= past.size()) pairs_.push_back({past[k - 1], past[k / 2 - 1]});
  longResidual(frame.input.rig, frame.input.measured_disparity_px, frame.range, pairs_,
               kMostParallax_px, frame.lattice(), residual_px_, pair_);
}

void AlongChannel::find(const FrameView& frame, Verification& verification) {
  const auto groups = firstResults(
      kMostAlong,
      groupResiduals(residual_px_, pair_, frame.input.measured_disparity_px,
                     static_cast<float>(frame.params.dense_min_residual_px)),
      [](const ResidualGroup& group) {
        return group.disparity_px >= kLeastDisparity_px ? std::optional(group) : std::nullopt;
      });
  verification.addAll(frame, static_cast<int>(groups.size()), [&](int i, SegmentationWork& work) {
    return verify(frame, groups[static_cast<size_t>(i)], verification, work);
  });
}

std::optional<VerifiedObject> AlongChannel::verify(const FrameView& frame,
                                                   const ResidualGroup& group,
                                                   const Verification& verification,
                                                   SegmentationWork& work) const {
  Hypothesis hypothesis;
  hypothesis.source = Hypothesis::Source::kAlong;
  hypothesis.seeds = group.points;
  if (!verification.isFree(hypothesis)) return std::nullopt;
  setLayer(frame, hypothesis);
  // An approaching object changes its size too much to be tracked over the longest time: try
  // shorter ones too.
  for (size_t k = pair_(group.points.front()); k < pairs_.size(); ++k) {
    const PastView view = frame.since(pairs_[k].past);
    const auto motion = motionOf(view, group.points);
    if (!motion) continue;
    hypothesis.moved_m = motion->moved_m;
    hypothesis.covariance = motion->covariance;
    if (auto found = verification.verify(view, nullptr, hypothesis, work)) return found;
  }
  return std::nullopt;
}

}  // namespace predictive_stereo
