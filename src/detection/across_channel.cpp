#include "detection/across_channel.h"

#include <algorithm>
#include <optional>

#include "detection/candidates.h"
#include "detection/suspect_groups.h"
#include "detection/unexplained_points.h"

namespace predictive_stereo {

void AcrossChannel::compare(const PastView& view, const cv::Mat1w& deviation,
                            const LevelGround& ground) {
  const FrameView& frame = view.frame;
  view.compare(view.static_source, cv::Rect(cv::Point(), frame.lattice()), static_world_);
  suspects_px_ = suspicion_.find(deviation, static_world_.mismatch, view.disparity_px(),
                                 frame.range, ground, frame.params);
}

void AcrossChannel::find(const PastView& view, Verification& verification) {
  const FrameView& frame = view.frame;
  const MotionDetectionParams& params = frame.params;
  suspects_px_.erase(std::remove_if(suspects_px_.begin(), suspects_px_.end(),
                                    [&](cv::Point p_px) { return verification.isTaken(p_px / 2); }),
                     suspects_px_.end());
  unexplainedPoints(view, suspects_px_, unexplained_px_);
  const std::vector<PointTrack> tracks = followGroups(view, groupSuspects(view, unexplained_px_));
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
      firstResults(kMostAcross, clusterTracks(view.rig(), params, tracks), hypothesisOf);
  verification.addAll(
      frame, static_cast<int>(hypotheses.size()), [&](int i, SegmentationWork& work) {
        return verification.verify(view, &static_world_, hypotheses[static_cast<size_t>(i)], work);
      });
}

}  // namespace predictive_stereo
