#include "detection/segmentation.h"

#include <algorithm>
#include <array>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "detection/constants.h"
#include "detection/long_residual.h"

namespace predictive_stereo {
namespace {

// Reach of the comparison's windows (twice 2), the smoothing (2) and the opening (1), rounded up.
constexpr int kReachOfWindows = 8;

// Removes shadows, ground and branches beside an object: columns that rise much less above the
// ground than the tallest columns. Where no ground is in view, there are none.
void dropLowColumns(const PastView& view, cv::Point origin, cv::Mat1b& mask) {
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
                                            (1 - kTail) * static_cast<double>(sorted.size() - 1));
  std::nth_element(sorted.begin(), tallest, sorted.end());
  const double lowest_m = kLowestColumn * std::max(*tallest, 0.0);
  for (int v = 0; v < mask.rows; ++v)
    for (int u = 0; u < mask.cols; ++u)
      if (heights_m[static_cast<size_t>(u)] < lowest_m) mask(v, u) = 0;
}

constexpr uchar kConnected = 254;

// The smallest box around the parts of the layer that are connected to a seed; empty if no seed is
// in the layer. Sets these parts to kConnected.
cv::Rect connectedToSeeds(const std::vector<cv::Point>& seeds, cv::Point origin, cv::Mat1b& layer) {
  cv::Rect all;
  const cv::Rect inside(cv::Point(), layer.size());
  for (cv::Point seed : seeds) {
    seed -= origin;
    if (!inside.contains(seed) || layer(seed) != 255) continue;
    cv::Rect box;
    cv::floodFill(layer, seed, kConnected, &box, {}, {}, 4);
    all |= box;
  }
  return all;
}

double latticePerMetre(const StereoRig& rig, const Hypothesis& hypothesis) {
  const double depth = rig.disparityTimesDepth() / hypothesis.disparity_px;
  return 0.5 * rig.fx_px / depth;
}

// The part of the lattice within half of the largest object from the seeds.
cv::Rect reachOf(const FrameView& frame, const Hypothesis& hypothesis) {
  const cv::Rect seen = cv::boundingRect(hypothesis.seeds);
  const double lattice_per_m = latticePerMetre(frame.input.rig, hypothesis);
  const int reach = static_cast<int>(frame.params.max_width_m / 2 * lattice_per_m) + 3;
  return cv::Rect(seen.x - reach, seen.y - reach, seen.width + 2 * reach, seen.height + 2 * reach) &
         cv::Rect(cv::Point(), frame.lattice());
}

// The hypothesis' disparity layer, as far as it is connected to seeds, with its surroundings.
struct Layer {
  cv::Rect area;   // lattice
  cv::Mat1b mask;  // 255 in the layer, 0 outside
};

// 255 on the lattice points in `area` that stand and whose disparity is in the layer.
cv::Mat1b standingLayer(const PastView& view, const Hypothesis& hypothesis, const cv::Rect& area) {
  // What is unknown is 0.
  const float farthest_px = std::max(hypothesis.farthest_px, std::numeric_limits<float>::min());
  cv::Mat1b layer;
  cv::inRange(view.frame.cells.lattice_px(area), farthest_px, hypothesis.nearest_px, layer);
  return layer & view.frame.obstacles.standing(area);
}

// Empty if no seed is in the layer.
Layer layerAround(const PastView& view, const Hypothesis& hypothesis, int margin) {
  const cv::Rect reachable = reachOf(view.frame, hypothesis);
  cv::Mat1b whole = standingLayer(view, hypothesis, reachable);
  const cv::Rect box = connectedToSeeds(hypothesis.seeds, reachable.tl(), whole);
  if (box.empty()) return {};
  const cv::Rect part =
      cv::Rect(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin) &
      cv::Rect(cv::Point(), reachable.size());
  return {part + reachable.tl(), whole(part) == kConnected};
}

// How much better the object's motion explains each cell than a static world does; 0: unknown.
cv::Mat1f supportOf(const PastView& view, const cv::Mat1f& static_world,
                    const Hypothesis& hypothesis, const cv::Rect& area) {
  Eigen::Isometry3d T_source = view.past.T_past_cam;
  T_source.translation() -= hypothesis.moved_m;
  cv::Mat1f by_object, by_static;
  view.compare(SourceOf(disparityMotion(view.rig(), T_source)), area, by_object);
  if (static_world.empty())
    view.compare(view.static_source, area, by_static);
  else
    by_static = static_world(area);
  cv::Mat1f support(area.size());
  for (int v = 0; v < area.height; ++v) {
    const float *const of_static = by_static[v], *const of_object = by_object[v];
    float* const of_row = support[v];
    for (int u = 0; u < area.width; ++u) {
      const bool unknown = (of_static[u] < 0) | (of_object[u] < 0);
      of_row[u] = unknown ? 0.0f : of_static[u] - of_object[u];
    }
  }
  return support;
}

// Cells that the object's motion explains better, and close cells that do not contradict.
cv::Mat1b supportedCells(const cv::Mat1b& layer, const cv::Mat1f& smooth, int gap) {
  cv::Mat1b core = (smooth > kDecisive_grey) & layer, member;
  cv::morphologyEx(core, core, cv::MORPH_OPEN, cv::Mat1b::ones(2, 2));
  cv::dilate(core, member, cv::Mat1b::ones(2 * gap + 1, 2 * gap + 1));
  cv::bitwise_and(member, (smooth >= -kDecisive_grey) & layer, member);
  cv::erode(member, member, cv::Mat1b::ones(2, 2));
  return member;
}

// The connected part with most of the points; empty if it has fewer than `fewest`.
/// @param cells  from `origin` on: 255, or 0. Overwritten.
cv::Mat1b partWith(const std::vector<cv::Point>& points, int fewest, cv::Point origin,
                   cv::Mat1b& cells) {
  constexpr int kMostParts = 254;  // more: the others are left out
  std::array<int, 256> points_in{};
  int parts = 0;
  const cv::Rect inside(cv::Point(), cells.size());
  for (cv::Point p : points) {
    p -= origin;
    if (!inside.contains(p)) continue;
    if (cells(p) == 255 && parts < kMostParts) cv::floodFill(cells, p, ++parts, nullptr, {}, {}, 4);
    ++points_in[cells(p)];
  }
  const auto most = std::max_element(&points_in[1], &points_in[1] + kMostParts);
  if (*most < std::max(fewest, 1)) return {};
  return cells == static_cast<int>(most - points_in.data());
}

// Cells that one explanation fits clearly better than the other.
struct Decisive {
  int better = 0, worse = 0;  // than a static world
};

Decisive countDecisive(const cv::Mat1b& layer, const cv::Mat1f& support, const cv::Rect& box) {
  Decisive cells;
  for (int v = box.y; v < box.br().y; ++v) {
    const uchar* const in_layer = layer[v];
    const float* const of_row = support[v];
    for (int u = box.x; u < box.br().x; ++u) {
      cells.better += (in_layer[u] != 0) & (of_row[u] > kDecisive_grey);
      cells.worse += (in_layer[u] != 0) & (of_row[u] < -kDecisive_grey);
    }
  }
  return cells;
}

// What the cells in the smallest box around the mask say; the mask must not be empty.
Segment segmentOf(const Layer& layer, const cv::Mat1f& support, const cv::Mat1b& mask,
                  const cv::Mat1f& residual_px, float least_residual) {
  const cv::Rect box = cv::boundingRect(mask);
  const cv::Point origin = layer.area.tl();
  Segment result;
  result.area = box + origin;
  result.mask = mask(box).clone();
  // Contradicting cells of the layer count, although they are not in the mask.
  const auto [better, worse] = countDecisive(layer.mask, support, box);
  result.decisive = better + worse;
  result.explained = result.decisive ? static_cast<double>(better) / result.decisive : 0;
  int positive = 0, negative = 0, known = 0;
  const cv::Rect of_cells(-origin, residual_px.size() * 2);  // the last points may be in no cell
  const cv::Rect counted = box & of_cells;
  for (int v = counted.y; v < counted.br().y; ++v)
    for (int u = counted.x; u < counted.br().x; ++u) {
      const float residual = residual_px((origin.y + v) / 2, (origin.x + u) / 2);
      if (!mask(v, u) || residual == kUnknownResidual) continue;
      ++known;
      positive += residual > least_residual;
      negative += residual < -least_residual;
    }
  result.dense = known ? static_cast<double>(std::max(positive, negative)) / known : 0;
  return result;
}

}  // namespace

void growOverLayer(const cv::Mat1b& layer, const cv::Mat1f& support, const cv::Mat1f& smooth,
                   double min_explained, cv::Mat1b& mask) {
  cv::Mat1b open = (smooth >= -kDecisive_grey) & layer;
  cv::morphologyEx(open, open, cv::MORPH_OPEN, cv::Mat1b::ones(3, 3));
  std::vector<cv::Point> cells;
  cv::findNonZero(mask, cells);
  const int count = static_cast<int>(cells.size());
  const cv::Mat1b part = partWith(cells, count / 2 + 1, {}, open);
  if (part.empty()) return;
  const cv::Mat1b grown = mask | part;
  if (cv::countNonZero(grown) > kMostGrown * count) return;
  // Refuted cells are in the layer, but not in the part: count in the whole box.
  const auto [better, worse] = countDecisive(layer, support, cv::boundingRect(grown));
  if (better >= min_explained * (better + worse)) mask = grown;
}

std::optional<Segment> segment(const PastView& view, const cv::Mat1f& static_world,
                               const cv::Mat1f& residual_px, const Hypothesis& hypothesis) {
  const std::vector<cv::Point>& seeds = hypothesis.seeds;
  if (seeds.empty()) return std::nullopt;
  const int gap =
      std::clamp(static_cast<int>(kGap_m * latticePerMetre(view.rig(), hypothesis)), 1, 20);
  const Layer layer = layerAround(view, hypothesis, gap + kReachOfWindows);
  if (layer.area.empty()) return std::nullopt;
  const cv::Mat1f support = supportOf(view, static_world, hypothesis, layer.area);
  cv::Mat1f smooth;
  cv::boxFilter(support, smooth, CV_32F, {5, 5});
  cv::Mat1b supported = supportedCells(layer.mask, smooth, gap);
  const auto third_of_seeds = static_cast<int>((seeds.size() + 2) / 3);
  cv::Mat1b mask = partWith(seeds, third_of_seeds, layer.area.tl(), supported);
  if (mask.empty()) return std::nullopt;
  growOverLayer(layer.mask, support, smooth, view.params().min_explained, mask);
  dropLowColumns(view, layer.area.tl(), mask);
  if (cv::countNonZero(mask) == 0) return std::nullopt;
  return segmentOf(layer, support, mask, residual_px,
                   0.5f * static_cast<float>(view.params().dense_min_residual_px));
}

}  // namespace predictive_stereo
