#include "detection/segmentation.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "detection/ground.h"

namespace predictive_stereo {
namespace {

constexpr float kDecisive_grey = 2.0f;  // difference of mismatches that is no noise
constexpr float kContradiction_grey = 0.7f;
constexpr int kFewestCells = 24;

// Columns and rows that hardly belong to the object: ground beside wheels, branches.
void trim(cv::Mat1b& mask, bool columns) {
  const int n = columns ? mask.cols : mask.rows;
  std::vector<int> sizes(static_cast<size_t>(n));
  for (int i = 0; i < n; ++i)
    sizes[static_cast<size_t>(i)] = cv::countNonZero(columns ? mask.col(i) : mask.row(i));
  std::vector<int> sorted = sizes;
  std::sort(sorted.begin(), sorted.end());
  const int high = sorted[static_cast<size_t>(0.8 * (n - 1))];
  const int least = std::max(1, static_cast<int>((columns ? 0.3 : 0.2) * high));
  for (int i = 0; i < n; ++i)
    if (sizes[static_cast<size_t>(i)] < least) (columns ? mask.col(i) : mask.row(i)).setTo(0);
}

}  // namespace

std::optional<Segment> segment(const SegmentationView& view, const MotionDetectionParams& params,
                               const Hypothesis& hypothesis) {
  if (hypothesis.seeds.empty()) return std::nullopt;
  const double fB = view.rig.disparityTimesDepth();
  const double depth = fB / hypothesis.disparity_px;
  const cv::Rect lattice(cv::Point(), view.static_mismatch.size());
  // As far as the largest object may reach from the seeds.
  const cv::Rect seen = cv::boundingRect(hypothesis.seeds);
  const double lattice_per_m = 0.5 * view.rig.fx_px / depth;
  const int wide = static_cast<int>(params.reach_m * lattice_per_m) + 3;
  const int high = static_cast<int>(params.reach_m * 0.6 * lattice_per_m) + 3;
  const cv::Rect area =
      cv::Rect(seen.x - wide, seen.y - high, seen.width + 2 * wide, seen.height + 2 * high) &
      lattice;
  Eigen::Isometry3d T_source = view.T_prev_cam;
  T_source.translation() -= hypothesis.moved_m;
  Comparison comparison;
  compareFrames(view.current, view.disparity_px, view.range, view.previous,
                SourceOf(disparityMotion(view.rig, T_source)), area, comparison);

  cv::Mat1b ground;
  levelGround(view.rig, view.range, view.disparity_px, area, ground);
  cv::Mat1f support(area.size());
  cv::Mat1b layer(area.size());
  for (int v = 0; v < area.height; ++v)
    for (int u = 0; u < area.width; ++u) {
      const float d = view.disparity_px(2 * (area.y + v), 2 * (area.x + u));
      const float by_static = view.static_mismatch(area.y + v, area.x + u);
      const float by_object = comparison.mismatch(v, u);
      layer(v, u) = view.range.isValid(d) && d >= hypothesis.farthest_px &&
                            d <= hypothesis.nearest_px && !ground(v, u)
                        ? 255
                        : 0;
      support(v, u) =
          by_static < 0 || by_object < 0 ? 0.0f : std::clamp(by_static - by_object, -15.0f, 15.0f);
    }
  cv::Mat1f smooth;
  cv::boxFilter(support, smooth, CV_32F, {5, 5});
  // What the object's motion explains better, and what lies close to it and does not object.
  cv::Mat1b core(area.size()), member(area.size());
  for (int v = 0; v < area.height; ++v)
    for (int u = 0; u < area.width; ++u)
      core(v, u) = layer(v, u) && smooth(v, u) > kContradiction_grey ? 255 : 0;
  cv::morphologyEx(core, core, cv::MORPH_OPEN, cv::Mat1b::ones(2, 2));
  const int gap = std::clamp(static_cast<int>(params.gap_m * lattice_per_m), 1, 20);
  cv::dilate(core, member, cv::Mat1b::ones(2 * gap + 1, 2 * gap + 1));
  for (int v = 0; v < area.height; ++v)
    for (int u = 0; u < area.width; ++u)
      if (!layer(v, u) || smooth(v, u) < -kContradiction_grey) member(v, u) = 0;
  cv::erode(member, member, cv::Mat1b::ones(2, 2));

  cv::Mat1i labels;
  const int count = cv::connectedComponents(member, labels, 4, CV_32S);
  std::vector<int> votes(static_cast<size_t>(count), 0);
  for (cv::Point seed : hypothesis.seeds)
    if (area.contains(seed)) ++votes[static_cast<size_t>(labels(seed - area.tl()))];
  votes[0] = 0;
  const auto best = std::max_element(votes.begin(), votes.end());
  if (*best * 3 < static_cast<int>(hypothesis.seeds.size())) return std::nullopt;
  cv::Mat1b mask = labels == static_cast<int>(best - votes.begin());
  trim(mask, true);
  trim(mask, false);
  const cv::Rect box = cv::boundingRect(mask);
  if (box.empty()) return std::nullopt;

  Segment result;
  result.area = box + area.tl();
  result.mask = mask(box).clone();
  int better = 0, worse = 0, positive = 0, negative = 0, known = 0;
  for (int v = box.y; v < box.br().y; ++v)
    for (int u = box.x; u < box.br().x; ++u) {
      // What contradicts inside the layer counts, although it is left out of the mask.
      if (layer(v, u)) {
        better += support(v, u) > kDecisive_grey;
        worse += support(v, u) < -kDecisive_grey;
      }
      if (!mask(v, u)) continue;
      ++result.cells;
      const float r = view.dense_residual_px(area.y + v, area.x + u);
      if (r < -1e5f) continue;
      ++known;
      positive += r > 0.5f * static_cast<float>(params.dense_min_residual_px);
      negative += r < -0.5f * static_cast<float>(params.dense_min_residual_px);
    }
  if (result.cells < kFewestCells) return std::nullopt;
  result.decisive = better + worse;
  result.explained = result.decisive ? static_cast<double>(better) / result.decisive : 0;
  result.dense =
      known * 3 >= result.cells ? static_cast<double>(std::max(positive, negative)) / known : 0;
  return result;
}

}  // namespace predictive_stereo
