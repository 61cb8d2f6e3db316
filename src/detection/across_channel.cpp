#include "detection/across_channel.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "detection/displacement_search.h"
#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

constexpr float kLeastGain = 1.5f;

double linkDisparity(const PastView& view, double d) {
  return 1 + kLinkDepth * view.params().link_distance_m * d * d / view.rig().disparityTimesDepth();
}

// Repeatedly takes the first free point, and all free points around it.
std::vector<SuspectGroup> groupsInSpace(const PastView& view,
                                        const std::vector<cv::Point>& points_px) {
  std::vector<float> disparities;
  for (cv::Point p : points_px) disparities.push_back(view.disparity_px()(p));
  std::vector<SuspectGroup> groups;
  std::vector<uchar> used(points_px.size(), 0);
  for (size_t first = 0; first < points_px.size(); ++first) {
    if (used[first]) continue;
    const float d = disparities[first];
    const double radius_px = view.params().link_distance_m * d / view.rig().baseline_m;
    const double link_px = linkDisparity(view, d);
    SuspectGroup group;
    for (size_t i = first; i < points_px.size(); ++i) {
      const cv::Point apart = points_px[i] - points_px[first];
      if (apart.y > radius_px) break;
      if (used[i] || apart.ddot(apart) > radius_px * radius_px ||
          std::abs(disparities[i] - d) > link_px)
        continue;
      used[i] = 1;
      group.points_px.push_back(points_px[i]);
    }
    if (static_cast<int>(group.points_px.size()) >= view.params().min_tracks)
      groups.push_back(std::move(group));
  }
  return groups;
}

// The lattice points of the group and their neighbours with a similar disparity.
std::vector<cv::Point> surroundings(const PastView& view, const SuspectGroup& group) {
  const float d = view.disparity_px()(group.points_px.front());
  const double link_px = linkDisparity(view, d);
  std::vector<cv::Point> lattice;
  lattice.reserve(9 * group.points_px.size());
  for (cv::Point p : group.points_px)
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const cv::Point at = p / 2 + cv::Point(dx, dy);
        const float other = view.disparity_px()(2 * at);
        if (view.isKnown(other) && std::abs(other - d) <= link_px) lattice.push_back(at);
      }
  return lattice;
}

void search(const PastView& view, SuspectGroup& group) {
  const double d = view.disparity_px()(group.points_px.front());
  const double most_px =
      view.params().largest_speed_mps * view.past.seconds * d / view.rig().baseline_m;
  const auto found =
      searchShift(view.images(), view.past_images(), view.static_source, view.disparity_px(),
                  surroundings(view, group), static_cast<int>(most_px / 2));
  if (!found) return;
  group.shift_px = found->shift_px;
  group.gain = found->gain;
}

}  // namespace

std::vector<SuspectGroup> groupSuspects(const PastView& view,
                                        const std::vector<cv::Point>& points_px) {
  std::vector<SuspectGroup> groups = groupsInSpace(view, points_px);
  parallelForEach(static_cast<int>(groups.size()),
                  [&](int i) { search(view, groups[static_cast<size_t>(i)]); });
  groups.erase(std::remove_if(groups.begin(), groups.end(),
                              [](const SuspectGroup& g) { return g.gain < kLeastGain; }),
               groups.end());
  return groups;
}

std::vector<PointTrack> followGroups(const PastView& view,
                                     const std::vector<SuspectGroup>& groups) {
  size_t points = 0;
  for (const SuspectGroup& group : groups) points += group.points_px.size();
  const size_t step = points / (kMostTracks + 1) + 1;
  std::vector<std::vector<PointTrack>> followed(groups.size());
  const auto follow = [&](size_t i) {
    SuspectGroup group = groups[i];
    const size_t count = group.points_px.size() / step;
    for (size_t k = 0; k < count; ++k) group.points_px[k] = group.points_px[k * step];
    group.points_px.resize(count);
    followed[i] = followPoints(view, group.points_px, group.shift_px);
    classify(view, followed[i]);
  };
  parallelForEach(static_cast<int>(groups.size()), [&](int i) { follow(static_cast<size_t>(i)); });
  std::vector<PointTrack> all;
  for (const auto& tracks : followed) all.insert(all.end(), tracks.begin(), tracks.end());
  return all;
}

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
