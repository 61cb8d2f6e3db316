#include "detection/motion_scheme.h"

#include <cmath>

#include "detection/candidates.h"
#include "detection/suspect_groups.h"
#include "detection/unexplained_points.h"

namespace predictive_stereo {
namespace {

using Source = Hypothesis::Source;

constexpr double kLargestSpeed_mps = 40;  // along the line of sight
}  // namespace

const std::vector<ObservedObject>& MotionScheme::observe(const DetectionInput& input,
                                                         const ObjectTracker& known) {
  frames_.remember(input, {[&] { verification_.findGround(input, range_); },
                           [&] { verification_.findRoad(input, range_); }});
  verification_.forgetObjects();
  const std::vector<PastFrame> past = frames_.past();
  if (past.empty()) return verification_.objects();
  const FrameView frame{input, range_, params_, frames_.current()};
  verification_.setFrame(frame);
  slow_.setFrame(frame, past);

  past_ = past[0];
  const std::vector<cv::Point>& suspects_px = compare(frame);
  frames_.setFollows(pose_check_.follows(suspicion_.share()));
  if (!frames_.current().follows) return verification_.objects();
  findAcross(frame, suspects_px);
  findAlong(frame);
  slow_.find(frame, verification_);
  findKnown(frame, known);
  verification_.joinParts(frame);
  return verification_.objects();
}

void MotionScheme::reset() {
  frames_.reset();
  pose_check_.reset();
  verification_.reset();
}

// The frame before against what the static world makes of it: its image and its disparities.
/// @return pixels whose images contradict.
const std::vector<cv::Point>& MotionScheme::compare(const FrameView& frame) {
  const SourceOf static_source = frame.staticSource(past_);
  residual_px_.create(frame.lattice());
  compareFrames(frame.current.pyramid, frame.input.measured_disparity_px, range_,
                past_.frame->pyramid, static_source, cv::Rect(cv::Point(), frame.lattice()),
                static_world_, [&](const LatticeRow& row, const RowSources& sources) {
                  denseResidualRow(frame.input, range_, row, sources, past_.frame->disparity_px,
                                   residual_px_);
                });
  return suspicion_.find(frame.current.pyramid.level(1), static_world_.mismatch,
                         frame.input.measured_disparity_px, verification_.ground(), params_);
}

// What moves across the line of sight, or fast: the image contradicts.
void MotionScheme::findAcross(const FrameView& frame, const std::vector<cv::Point>& suspects_px) {
  const StereoRig& rig = frame.input.rig;
  const TrackingView view = frame.trackingInto(past_);
  unexplainedPoints(view, params_, past_.seconds, suspects_px, unexplained_px_);
  const std::vector<PointTrack> tracks =
      followGroups(view, params_, groupSuspects(view, params_, unexplained_px_, past_.seconds));
  const auto hypothesisOf = [&](const std::vector<size_t>& members) -> std::optional<Hypothesis> {
    const Displacement fit = fitDisplacement(rig, params_, tracks, members);
    if (static_cast<int>(fit.inliers.size()) < params_.min_tracks ||
        fit.moved_m.norm() < params_.min_displacement_m)
      return std::nullopt;
    Hypothesis hypothesis;
    hypothesis.source = Source::kTracks;
    hypothesis.moved_m = fit.moved_m;
    hypothesis.covariance = fit.covariance;
    for (size_t i : fit.inliers)
      hypothesis.seeds.emplace_back(static_cast<int>(tracks[i].position.x) / 2,
                                    static_cast<int>(tracks[i].position.y) / 2);
    setLayer(frame, hypothesis);
    return hypothesis;
  };
  const std::vector<Hypothesis> hypotheses =
      firstFew(kMostAcross, clusterTracks(rig, params_, tracks), hypothesisOf);
  verification_.addAll(frame, static_cast<int>(hypotheses.size()),
                       [&](int i, VerificationWork& work) {
                         return verification_.verify(
                             frame, baseline(), hypotheses[static_cast<size_t>(i)], nullptr, work);
                       });
}

// What moves along the line of sight: the disparity contradicts.
void MotionScheme::findAlong(const FrameView& frame) {
  // So far away that such a residual would be faster than anything on a road.
  const double farthest_px =
      std::sqrt(frame.input.rig.disparityTimesDepth() * params_.dense_min_residual_px /
                (kLargestSpeed_mps * past_.seconds));
  const auto groups = firstFew(
      kMostAlong, along_groups_.find(residual_px_, frame.input.measured_disparity_px, params_),
      [&](const DenseGroup& group) {
        return group.disparity_px >= farthest_px && isLargeEnough(frame, group)
                   ? std::optional(&group)
                   : std::nullopt;
      });
  const auto find = [&](int i, VerificationWork& work) -> std::optional<VerifiedObject> {
    const DenseGroup& group = *groups[static_cast<size_t>(i)];
    Hypothesis hypothesis;
    hypothesis.source = Source::kDense;
    hypothesis.seeds = group.points;
    if (!verification_.isFree(hypothesis)) return std::nullopt;
    const auto motion = motionOf(frame, past_, group);
    if (!motion) return std::nullopt;
    setLayer(frame, hypothesis);
    hypothesis.moved_m = motion->fit.moved_m;
    hypothesis.covariance = motion->fit.covariance;
    return verification_.verify(frame, baseline(), hypothesis, nullptr, work);
  };
  verification_.addAll(frame, static_cast<int>(groups.size()), find);
}

// Known objects are looked for where they should be.
void MotionScheme::findKnown(const FrameView& frame, const ObjectTracker& known) {
  std::vector<const ObjectTrack*> tracks;
  for (const ObjectTrack& track : known.tracks())
    if (track.confirmed) tracks.push_back(&track);
  const auto find = [&](int i, VerificationWork& work) -> std::optional<VerifiedObject> {
    const auto hypothesis = hypothesisOf(frame, past_, *tracks[static_cast<size_t>(i)]);
    if (!hypothesis || !verification_.isFree(*hypothesis)) return std::nullopt;
    return verification_.verify(frame, baseline(), *hypothesis, nullptr, work);
  };
  const auto added = verification_.addAll(frame, static_cast<int>(tracks.size()), find);
  std::vector<const ObjectTrack*> missing;
  for (size_t i = 0; i < tracks.size(); ++i)
    if (!added[i]) missing.push_back(tracks[i]);
  slow_.findKnown(frame, missing, verification_);
}

}  // namespace predictive_stereo
