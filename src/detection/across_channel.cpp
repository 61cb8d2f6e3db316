#include "detection/across_channel.h"

#include <algorithm>
#include <optional>

#include "detection/candidates.h"
#include "detection/suspect_groups.h"
#include "detection/unexplained_points.h"

namespace predictive_stereo {

void AcrossChannel::compare(const FrameView& frame, const PastFrame& past,
                            const LevelGround& ground) {
  past_ = past;
  compareFrames(frame.current.pyramid, frame.input.measured_disparity_px, frame.range,
                past.frame->pyramid, frame.staticSource(past),
                cv::Rect(cv::Point(), frame.lattice()), static_world_);
  suspects_px_ =
      suspicion_.find(frame.current.pyramid.level(1), static_world_.mismatch,
                      frame.input.measured_disparity_px, frame.range, ground, frame.params);
}

void AcrossChannel::find(const FrameView& frame, Verification& verification) {
  const StereoRig& rig = frame.input.rig;
  const MotionDetectionParams& params = frame.params;
  const TrackingView view = frame.trackingInto(past_);
  suspects_px_.erase(std::remove_if(suspects_px_.begin(), suspects_px_.end(),
                                    [&](cv::Point p_px) { return verification.isTaken(p_px / 2); }),
                     suspects_px_.end());
  unexplainedPoints(view, params, past_.seconds, suspects_px_, unexplained_px_);
  const std::vector<PointTrack> tracks =
      followGroups(view, params, groupSuspects(view, params, unexplained_px_, past_.seconds));
  const auto hypothesisOf = [&](const std::vector<size_t>& members) -> std::optional<Hypothesis> {
    const Displacement fit = fitDisplacement(view, tracks, members);
    if (static_cast<int>(fit.inliers.size()) < params.min_tracks || !fit.isSignificant(params))
      return std::nullopt;
    Hypothesis hypothesis;
    hypothesis.source = Hypothesis::Source::kAcross;
    hypothesis.moved_m = fit.moved_m;
    hypothesis.covariance = fit.covariance;
    for (size_t i : fit.inliers)
      hypothesis.seeds.emplace_back(static_cast<int>(tracks[i].position.x) / 2,
                                    static_cast<int>(tracks[i].position.y) / 2);
    setLayer(frame, hypothesis);
    return hypothesis;
  };
  const std::vector<Hypothesis> hypotheses =
      firstResults(kMostAcross, clusterTracks(rig, params, tracks), hypothesisOf);
  verification.addAll(
      frame, static_cast<int>(hypotheses.size()), [&](int i, VerificationWork& work) {
        return verification.verify(frame, baseline(), hypotheses[static_cast<size_t>(i)], work);
      });
}

}  // namespace predictive_stereo
