#include "detection/segmentation.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "detection/long_residual.h"
#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detection/segmentation.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

// Short loops without branches, which compilers vectorise.

HWY_NOINLINE void layerRow(const float* HWY_RESTRICT disparity_px,
                           const float* HWY_RESTRICT below_m, int width, float farthest_px,
                           float nearest_px, float lowest_m, uint8_t* HWY_RESTRICT layer) {
  for (int u = 0; u < width; ++u) {
    const float d = disparity_px[2 * u];
    const int32_t inside = (d >= farthest_px) & (d <= nearest_px) & (below_m[u] < lowest_m);
    layer[u] = static_cast<uint8_t>(-inside);
  }
}

HWY_NOINLINE void supportRow(const float* HWY_RESTRICT by_static,
                             const float* HWY_RESTRICT by_object, int width, float most,
                             float* HWY_RESTRICT support) {
  for (int u = 0; u < width; ++u) {
    const float difference = by_static[u] - by_object[u];
    const float lower = difference < most ? difference : most;
    const float clamped = lower > -most ? lower : -most;
    support[u] = (by_static[u] < 0) | (by_object[u] < 0) ? 0.0f : clamped;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace predictive_stereo {
namespace {

HWY_EXPORT(layerRow);
HWY_EXPORT(supportRow);

constexpr float kDecisive_grey = 2.0f;  // difference of mismatches above noise
constexpr float kContradiction_grey = 0.7f;
constexpr float kMostSupport_grey = 15.0f;
constexpr int kFewestCells = 24;
// From an object's points to its end, relative to MotionDetectionParams::link_distance_m.
constexpr double kReach = 1.6;
// Reach of the comparison's windows (twice 2), the smoothing (2) and the opening (1), rounded up.
constexpr int kReachOfWindows = 8;

// Removes shadows, ground and branches beside an object: columns that rise much less above the
// ground than the tallest columns. Where no ground is in view, there are none.
void dropLowColumns(const PastView& view, cv::Point origin, cv::Mat1b& mask) {
  constexpr double kLowest = 0.35, kTallest = 0.95;  // of the height; of the columns
  constexpr double kEmpty_m = -1e6;
  const std::optional<GroundPlane>& ground = view.frame.ground;
  if (!ground) return;
  std::vector<double> heights_m(static_cast<size_t>(mask.cols), kEmpty_m), sorted;
  for (int u = 0; u < mask.cols; ++u) {
    double& height_m = heights_m[static_cast<size_t>(u)];
    for (int v = 0; v < mask.rows; ++v) {
      if (!mask(v, u)) continue;
      const cv::Point pixel = 2 * (origin + cv::Point(u, v));
      const float d = view.disparity_px()(pixel);
      if (d > 0) height_m = std::max(height_m, ground->heightAt(pixel.x, pixel.y, d));
    }
    if (height_m > kEmpty_m) sorted.push_back(height_m);
  }
  if (sorted.empty()) return;
  const auto tallest = sorted.begin() + static_cast<std::ptrdiff_t>(
                                            kTallest * static_cast<double>(sorted.size() - 1));
  std::nth_element(sorted.begin(), tallest, sorted.end());
  const double lowest_m = kLowest * std::max(*tallest, 0.0);
  for (int u = 0; u < mask.cols; ++u)
    if (heights_m[static_cast<size_t>(u)] < lowest_m) mask.col(u).setTo(0);
}

// The smallest box around the parts of the layer that are connected to a seed; empty if no seed is
// in the layer. Sets these parts to a value other than 0 and 255.
cv::Rect connectedToSeeds(const std::vector<cv::Point>& seeds, cv::Point origin, cv::Mat1b& layer) {
  cv::Rect all;
  const cv::Rect inside(cv::Point(), layer.size());
  for (cv::Point seed : seeds) {
    seed -= origin;
    if (!inside.contains(seed) || layer(seed) != 255) continue;
    cv::Rect box;
    cv::floodFill(layer, seed, 254, &box, {}, {}, 4);
    all |= box;
  }
  return all;
}

double latticePerMetre(const StereoRig& rig, const Hypothesis& hypothesis) {
  const double depth = rig.disparityTimesDepth() / hypothesis.disparity_px;
  return 0.5 * rig.fx_px / depth;
}

// The part of the lattice within the largest object's reach from the seeds.
cv::Rect reachOf(const FrameView& frame, const Hypothesis& hypothesis) {
  const cv::Rect seen = cv::boundingRect(hypothesis.seeds);
  const double lattice_per_m = latticePerMetre(frame.input.rig, hypothesis);
  const double reach_m = kReach * frame.params.link_distance_m;
  const int wide = static_cast<int>(reach_m * lattice_per_m) + 3;
  const int high = static_cast<int>(reach_m * 0.6 * lattice_per_m) + 3;
  return cv::Rect(seen.x - wide, seen.y - high, seen.width + 2 * wide, seen.height + 2 * high) &
         cv::Rect(cv::Point(), frame.lattice());
}

// The hypothesis' disparity layer, as far as it is connected to seeds, with its surroundings.
struct Layer {
  cv::Rect area;   // lattice
  cv::Mat1b mask;  // 0 outside the layer
};

// Empty if no seed is in the layer.
Layer layerAround(const PastView& view, const LevelGround& ground, const Hypothesis& hypothesis,
                  int margin, SegmentationWork& work) {
  const cv::Rect reachable = reachOf(view.frame, hypothesis);
  const float lowest_m = ground.lowestIn(reachable, work.heights);
  cv::Mat1b whole = work.layer.map(reachable.size());
  for (int v = 0; v < reachable.height; ++v) HWY_DYNAMIC_DISPATCH(layerRow)
  (view.disparity_px()[2 * (reachable.y + v)] + 2 * reachable.x,
   ground.below_m(reachable.y + v) + reachable.x, reachable.width, hypothesis.farthest_px,
   hypothesis.nearest_px, lowest_m, whole[v]);
  const cv::Rect box = connectedToSeeds(hypothesis.seeds, reachable.tl(), whole);
  if (box.empty()) return {};
  const cv::Rect part =
      cv::Rect(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin) &
      cv::Rect(cv::Point(), reachable.size());
  return {part + reachable.tl(), whole(part)};
}

// How much better the object's motion explains each cell than a static world does.
cv::Mat1f supportOf(const PastView& view, const Comparison* static_world,
                    const Hypothesis& hypothesis, const cv::Rect& area, SegmentationWork& work) {
  Eigen::Isometry3d T_source = view.past.T_past_cam;
  T_source.translation() -= hypothesis.moved_m;
  view.compare(SourceOf(disparityMotion(view.rig(), T_source)), area, work.by_object);
  if (!static_world) {
    view.compare(view.static_source, area, work.by_static);
    static_world = &work.by_static;
  }
  cv::Mat1f support = work.support.map(area.size());
  const cv::Point first = area.tl() - static_world->area.tl();
  for (int v = 0; v < area.height; ++v) HWY_DYNAMIC_DISPATCH(supportRow)
  (static_world->mismatch[first.y + v] + first.x, work.by_object.mismatch[v], area.width,
   kMostSupport_grey, support[v]);
  return support;
}

// Cells that the object's motion explains better, and close cells that do not contradict.
cv::Mat1b supportedCells(const Layer& layer, const cv::Mat1f& smooth,
                         const std::vector<cv::Point>& seeds, int gap, SegmentationWork& work) {
  const cv::Rect& area = layer.area;
  cv::Mat1b core = work.core.map(area.size()), member = work.member.map(area.size());
  cv::bitwise_and(smooth > kContradiction_grey, layer.mask != 0, core);
  cv::morphologyEx(core, core, cv::MORPH_OPEN, cv::Mat1b::ones(2, 2));
  // Seeds were tracked. If texture is weak, hardly anything else shows the object.
  for (cv::Point seed : seeds) {
    const cv::Rect around = (cv::Rect(seed.x - 1, seed.y - 1, 3, 3) & area) - area.tl();
    for (int v = around.y; v < around.br().y; ++v)
      for (int u = around.x; u < around.br().x; ++u)
        if (layer.mask(v, u) && smooth(v, u) >= -kContradiction_grey) core(v, u) = 255;
  }
  cv::dilate(core, member, cv::Mat1b::ones(2 * gap + 1, 2 * gap + 1));
  member.setTo(0, (smooth < -kContradiction_grey) | (layer.mask == 0));
  cv::erode(member, member, cv::Mat1b::ones(2, 2));
  return member;
}

// The connected part with most seeds; none if it has less than a third of them.
std::optional<cv::Mat1b> partWithSeeds(const cv::Mat1b& member, const cv::Rect& area,
                                       const std::vector<cv::Point>& seeds,
                                       SegmentationWork& work) {
  cv::Mat1i labels = work.labels.map(area.size());
  const int count = cv::connectedComponents(member, labels, 4, CV_32S);
  std::vector<int> votes(static_cast<size_t>(count), 0);
  for (cv::Point seed : seeds)
    if (area.contains(seed)) ++votes[static_cast<size_t>(labels(seed - area.tl()))];
  votes[0] = 0;
  const auto best = std::max_element(votes.begin(), votes.end());
  const int best_label = static_cast<int>(best - votes.begin());
  if (*best * 3 < static_cast<int>(seeds.size())) return std::nullopt;
  cv::Mat1b mask = work.mask.map(area.size());
  for (int v = 0; v < area.height; ++v)
    for (int u = 0; u < area.width; ++u) mask(v, u) = labels(v, u) == best_label ? 255 : 0;
  return mask;
}

// What the cells in the smallest box around the mask say; the mask must not be empty.
Segment segmentOf(const Layer& layer, const cv::Mat1f& support, const cv::Mat1b& mask,
                  const cv::Mat1f& residual_px, float least_residual) {
  const cv::Rect box = cv::boundingRect(mask);
  const cv::Point origin = layer.area.tl();
  Segment result;
  result.area = box + origin;
  result.mask = mask(box).clone();
  int better = 0, worse = 0, positive = 0, negative = 0, known = 0;
  for (int v = box.y; v < box.br().y; ++v) {
    const float *of_row = support[v], *residual = residual_px[origin.y + v] + origin.x;
    const uchar *in_layer = layer.mask[v], *in_mask = mask[v];
    for (int u = box.x; u < box.br().x; ++u) {
      // Contradicting cells of the layer count, although they are not in the mask.
      better += in_layer[u] && of_row[u] > kDecisive_grey;
      worse += in_layer[u] && of_row[u] < -kDecisive_grey;
      if (!in_mask[u]) continue;
      ++result.cells;
      if (residual[u] == kUnknownResidual) continue;
      ++known;
      positive += residual[u] > least_residual;
      negative += residual[u] < -least_residual;
    }
  }
  result.decisive = better + worse;
  result.explained = result.decisive ? static_cast<double>(better) / result.decisive : 0;
  result.dense =
      known * 3 >= result.cells ? static_cast<double>(std::max(positive, negative)) / known : 0;
  return result;
}

constexpr int kMostGrowth = 4;              // cells after / before
constexpr double kMostContradicting = 0.5;  // contradicting cells / supporting cells

}  // namespace

void layerRow(const float* disparity_px, const float* below_m, int width, float farthest_px,
              float nearest_px, float lowest_m, uint8_t* layer) {
  HWY_DYNAMIC_DISPATCH(layerRow)
  (disparity_px, below_m, width, farthest_px, nearest_px, lowest_m, layer);
}

void supportRow(const float* by_static, const float* by_object, int width, float most,
                float* support) {
  HWY_DYNAMIC_DISPATCH(supportRow)(by_static, by_object, width, most, support);
}

void growOverLayer(const cv::Mat1b& layer, const cv::Mat1f& support, const cv::Mat1f& smooth,
                   float least_smooth, float decisive, cv::Mat1b& mask, SegmentationWork& work) {
  cv::Mat1b open = work.open.map(layer.size());
  cv::bitwise_and(smooth >= least_smooth, layer != 0, open);
  cv::morphologyEx(open, open, cv::MORPH_OPEN, cv::Mat1b::ones(3, 3));

  cv::Mat1i labels = work.labels.map(layer.size());
  const int count = cv::connectedComponents(open, labels, 4, CV_32S);
  std::vector<int>& common = work.common;
  common.assign(static_cast<size_t>(count), 0);
  int cells = 0;
  for (int v = 0; v < mask.rows; ++v)
    for (int u = 0; u < mask.cols; ++u)
      if (mask(v, u)) ++cells, ++common[static_cast<size_t>(labels(v, u))];
  common[0] = 0;
  const auto most = std::max_element(common.begin(), common.end());
  if (2 * *most <= cells) return;
  const int part = static_cast<int>(most - common.begin());

  cv::Mat1b grown = work.grown.map(layer.size());
  int grown_cells = 0;
  for (int v = 0; v < mask.rows; ++v)
    for (int u = 0; u < mask.cols; ++u) {
      const bool inside = mask(v, u) || labels(v, u) == part;
      grown(v, u) = inside ? 255 : 0;
      grown_cells += inside;
    }
  if (grown_cells > kMostGrowth * cells) return;
  // Refuted cells are in the layer, but not in the part: count in the whole box.
  const cv::Rect box = cv::boundingRect(grown);
  int supporting = 0, contradicting = 0;
  for (int v = box.y; v < box.br().y; ++v)
    for (int u = box.x; u < box.br().x; ++u) {
      supporting += layer(v, u) && support(v, u) > decisive;
      contradicting += layer(v, u) && support(v, u) < -decisive;
    }
  if (contradicting > kMostContradicting * supporting) return;
  grown.copyTo(mask);
}

std::optional<Segment> segment(const PastView& view, const SegmentationMaps& maps,
                               const Hypothesis& hypothesis, SegmentationWork& work) {
  const std::vector<cv::Point>& seeds = hypothesis.seeds;
  if (seeds.empty()) return std::nullopt;
  const int gap =
      std::clamp(static_cast<int>(kGap_m * latticePerMetre(view.rig(), hypothesis)), 1, 20);
  const Layer layer = layerAround(view, maps.ground, hypothesis, gap + kReachOfWindows, work);
  if (layer.area.empty()) return std::nullopt;
  const cv::Mat1f support = supportOf(view, maps.static_world, hypothesis, layer.area, work);
  cv::Mat1f smooth = work.smooth.map(layer.area.size());
  cv::boxFilter(support, smooth, CV_32F, {5, 5});
  auto mask =
      partWithSeeds(supportedCells(layer, smooth, seeds, gap, work), layer.area, seeds, work);
  if (!mask) return std::nullopt;
  growOverLayer(layer.mask, support, smooth, -kContradiction_grey, kDecisive_grey, *mask, work);
  dropLowColumns(view, layer.area.tl(), *mask);
  if (cv::countNonZero(*mask) < kFewestCells) return std::nullopt;
  return segmentOf(layer, support, *mask, maps.residual_px,
                   0.5f * static_cast<float>(view.params().dense_min_residual_px));
}

}  // namespace predictive_stereo
#endif
