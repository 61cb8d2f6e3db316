#include "detection/motion_scheme.h"

#include <cmath>

#include "detection/suspect_groups.h"
#include "detection/unexplained_points.h"

namespace predictive_stereo {
namespace {

using Source = Hypothesis::Source;

constexpr double kLargestSpeed_mps = 40;  // along the line of sight

}  // namespace

const std::vector<ObservedObject>& MotionScheme::observe(const DetectionInput& input,
                                                         const ObjectTracker& known) {
  frames_.remember(input);
  verification_.forgetObjects();
  const std::vector<PastFrame> past = frames_.past();
  if (past.empty()) return verification_.objects();
  const FrameView frame{input, range_, params_, frames_.current()};
  verification_.setFrame(frame);
  slow_.setFrame(frame, past);

  const std::vector<cv::Point>& suspects_px = compare(frame, past[0]);
  frames_.setFollows(pose_check_.follows(suspicion_.share()));
  if (!frames_.current().follows) return verification_.objects();
  denseResidual(input, range_, frame.staticSource(past[0]), past[0].frame->disparity_px,
                frame.lattice(), baseline_.residual_px);
  findAcross(frame, suspects_px);
  findAlong(frame);
  slow_.find(frame, verification_);
  for (const ObjectTrack& track : known.tracks())
    if (track.confirmed) findKnown(frame, track);
  verification_.joinParts(frame);
  return verification_.objects();
}

void MotionScheme::reset() {
  frames_.reset();
  pose_check_.reset();
  verification_.reset();
}

// The frame before against what the static world makes of it.
/// @return pixels that contradict.
const std::vector<cv::Point>& MotionScheme::compare(const FrameView& frame, const PastFrame& past) {
  baseline_.past = past;
  compareFrames(frame.current.pyramid, frame.input.measured_disparity_px, range_,
                past.frame->pyramid, frame.staticSource(past),
                cv::Rect(cv::Point(), frame.lattice()), baseline_.static_world);
  return suspicion_.find(frame.current.pyramid.level(1), baseline_.static_world.mismatch,
                         frame.input.measured_disparity_px, verification_.ground(), params_);
}

// What moves across the line of sight, or fast: the image contradicts.
void MotionScheme::findAcross(const FrameView& frame, const std::vector<cv::Point>& suspects_px) {
  const StereoRig& rig = frame.input.rig;
  const double seconds = baseline_.past.seconds;
  const TrackingView view = frame.trackingInto(baseline_.past);
  unexplainedPoints(view, params_, seconds, suspects_px, unexplained_px_);
  const std::vector<PointTrack> tracks =
      followGroups(view, params_, groupSuspects(view, params_, unexplained_px_, seconds));
  for (const auto& members : clusterTracks(rig, params_, tracks)) {
    const Displacement fit = fitDisplacement(rig, params_, tracks, members);
    if (static_cast<int>(fit.inliers.size()) < params_.min_tracks ||
        fit.moved_m.norm() < params_.min_displacement_m)
      continue;
    Hypothesis hypothesis;
    hypothesis.source = Source::kTracks;
    hypothesis.moved_m = fit.moved_m;
    hypothesis.covariance = fit.covariance;
    for (size_t i : fit.inliers)
      hypothesis.seeds.emplace_back(static_cast<int>(tracks[i].position.x) / 2,
                                    static_cast<int>(tracks[i].position.y) / 2);
    setLayer(frame, hypothesis);
    verification_.add(frame, baseline_, hypothesis);
  }
}

// What moves along the line of sight: the disparity contradicts.
void MotionScheme::findAlong(const FrameView& frame) {
  const PastFrame& past = baseline_.past;
  // So far away that such a residual would be faster than anything on a road.
  const double farthest_px =
      std::sqrt(frame.input.rig.disparityTimesDepth() * params_.dense_min_residual_px /
                (kLargestSpeed_mps * past.seconds));
  for (const DenseGroup& group :
       along_groups_.find(baseline_.residual_px, frame.input.measured_disparity_px, params_)) {
    if (group.disparity_px < farthest_px || !isLargeEnough(frame, group)) continue;
    Hypothesis hypothesis;
    hypothesis.source = Source::kDense;
    hypothesis.seeds = group.points;
    if (!verification_.isFree(hypothesis)) continue;
    const auto motion = motionOf(frame, past, group);
    if (!motion) continue;
    setLayer(frame, hypothesis);
    hypothesis.moved_m = motion->fit.moved_m;
    hypothesis.covariance = motion->fit.covariance;
    verification_.add(frame, baseline_, hypothesis);
  }
}

// A known object is looked for where it should be.
void MotionScheme::findKnown(const FrameView& frame, const ObjectTrack& known) {
  const auto hypothesis = hypothesisOf(frame, baseline_.past, known);
  if (hypothesis && verification_.isFree(*hypothesis) &&
      verification_.add(frame, baseline_, *hypothesis))
    return;
  slow_.findKnown(frame, known, verification_);
}

}  // namespace predictive_stereo
