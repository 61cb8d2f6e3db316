#include "detection/across_channel.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "detection/constants.h"
#include "detection/displacement_search.h"
#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

double linkDisparity(const PastView& view, double d) {
  return kDisparityError_px +
         kLinkDepth * view.params().link_distance_m * d * d / view.rig().disparityTimesDepth();
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
  const auto found = searchShift(view, surroundings(view, group), static_cast<int>(most_px / 2));
  if (!found) return;
  group.shift_px = found->shift_px;
  group.gain = found->gain;
}

// None if the motion of these points is not significant.
std::optional<Hypothesis> hypothesisOf(const PastView& view, const std::vector<PointTrack>& alike) {
  const auto motion = significantMotion(view, alike);
  if (!motion) return std::nullopt;
  Hypothesis hypothesis;
  hypothesis.source = Hypothesis::Source::kAcross;
  hypothesis.moved_m = motion->moved_m;
  hypothesis.covariance = motion->covariance;
  for (size_t i : motion->inliers)
    hypothesis.seeds.emplace_back(static_cast<int>(alike[i].position.x) / 2,
                                  static_cast<int>(alike[i].position.y) / 2);
  setLayer(view.frame, hypothesis);
  return hypothesis;
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
    const std::vector<cv::Point>& points_px = groups[i].points_px;
    std::vector<cv::Point> sample;
    for (size_t k = 0; k < points_px.size() / step; ++k) sample.push_back(points_px[k * step]);
    followed[i] = followPoints(view, sample, groups[i].shift_px);
  };
  parallelForEach(static_cast<int>(groups.size()), [&](int i) { follow(static_cast<size_t>(i)); });
  std::vector<PointTrack> all;
  for (const auto& tracks : followed) all.insert(all.end(), tracks.begin(), tracks.end());
  return all;
}

void AcrossChannel::compare(const PastView& view, const cv::Mat1f& texture) {
  view.compare(view.static_source, cv::Rect(cv::Point(), view.frame.lattice()), static_world);
  suspects = findSuspects(view.frame, texture, static_world);
}

void AcrossChannel::find(const PastView& view, Verification& verification) const {
  std::vector<cv::Point> points_px;
  for (cv::Point p_px : suspects.points_px)
    if (!verification.isTaken(p_px / 2)) points_px.push_back(p_px);
  const std::vector<PointTrack> tracks =
      followGroups(view, groupSuspects(view, unexplainedPoints(view, points_px)));
  const auto hypotheses =
      firstResults(clusterTracks(view, tracks),
                   [&](const std::vector<PointTrack>& alike) { return hypothesisOf(view, alike); });
  verification.addAll(view.frame, hypotheses, [&](const Hypothesis& hypothesis) {
    return verification.verify(view, static_world, hypothesis);
  });
}

}  // namespace predictive_stereo
