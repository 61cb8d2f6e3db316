#include "detection/along_channel.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "detection/constants.h"
#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

// Frames that are compared, if static points have not moved more since then.
constexpr size_t kFramesBack[] = {8, 6, 4, 2};
static_assert(kFramesBack[0] == FrameHistory::kFarthest);

constexpr uchar kNoSeed = 0;

// Residuals of cells.
struct Sum {
  float px = 0;
  int known = 0, signs = 0;

  void add(float residual_px) {
    if (residual_px == kUnknownResidual) return;
    px += residual_px;
    ++known;
    signs += (residual_px > 0) - (residual_px < 0);
  }
  // Whether they are enough, large and of one sign.
  bool isShift(float least_mean_px) const {
    const auto count = static_cast<float>(known);
    return known >= kFewestOfNine && std::abs(px) >= least_mean_px * count &&
           static_cast<float>(std::abs(signs)) >= kLeastSign * count;
  }
};

// Of the 3x3 cells around one; the map's border cuts them.
Sum sumAround(const cv::Mat1f& residual_px, cv::Point at) {
  Sum sum;
  for (int v = std::max(at.y - 1, 0); v <= std::min(at.y + 1, residual_px.rows - 1); ++v)
    for (int u = std::max(at.x - 1, 0); u <= std::min(at.x + 1, residual_px.cols - 1); ++u)
      sum.add(residual_px(v, u));
  return sum;
}

// Seeds of one value have the same pair and sign.
cv::Mat1b findSeeds(const cv::Mat1f& residual_px, const cv::Mat1b& pair, float least_mean_px) {
  cv::Mat1b seeds(residual_px.size(), kNoSeed);
  parallelForEach(seeds.rows, [&](int v) {
    for (int u = 0; u < seeds.cols; ++u) {
      const float r = residual_px(v, u);
      if (r == kUnknownResidual || std::abs(r) < 0.5f * least_mean_px) continue;
      const Sum sum = sumAround(residual_px, {u, v});
      if (sum.isShift(least_mean_px))
        seeds(v, u) = static_cast<uchar>(2 * pair(v, u) + (sum.px > 0 ? 1 : 2));
    }
  });
  return seeds;
}

// The seeds that are connected to the first one, which are then none any more.
std::vector<cv::Point> takeConnected(const cv::Mat1f& cells_px, cv::Point first, cv::Mat1b& seeds) {
  const uchar kind = seeds(first);
  std::vector<cv::Point> open{first}, taken;
  seeds(first) = kNoSeed;
  while (!open.empty()) {
    const cv::Point p = open.back();
    open.pop_back();
    taken.push_back(p);
    const float d = cells_px(p);
    for (const cv::Point step : {cv::Point(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
      const cv::Point q = p + step;
      if (!cv::Rect(cv::Point(), seeds.size()).contains(q) || seeds(q) != kind ||
          std::abs(cells_px(q) - d) > kDisparityError_px)
        continue;
      seeds(q) = kNoSeed;
      open.push_back(q);
    }
  }
  return taken;
}

// As lattice points, those that have a disparity.
std::vector<cv::Point> pointsOf(const FrameView& frame, const std::vector<cv::Point>& cells) {
  static_assert(kCellSide_px == 4, "a cell is 2x2 lattice points");
  std::vector<cv::Point> points;
  for (const cv::Point cell : cells)
    for (const cv::Point step : {cv::Point(0, 0), {1, 0}, {0, 1}, {1, 1}})
      if (const cv::Point p = 2 * cell + step;
          frame.range.isValid(frame.input.measured_disparity_px(2 * p)))
        points.push_back(p);
  return points;
}

}  // namespace

std::vector<std::vector<cv::Point>> groupResiduals(const cv::Mat1f& residual_px,
                                                   const cv::Mat1b& pair, const cv::Mat1f& cells_px,
                                                   float least_mean_px) {
  cv::Mat1b seeds = findSeeds(residual_px, pair, least_mean_px);
  std::vector<std::vector<cv::Point>> groups;
  for (int v = 0; v < seeds.rows; ++v)
    for (int u = 0; u < seeds.cols; ++u)
      if (seeds(v, u) != kNoSeed) groups.push_back(takeConnected(cells_px, {u, v}, seeds));
  return groups;
}

std::vector<std::vector<cv::Point>> shiftedObstacles(const Obstacles& obstacles,
                                                     const cv::Mat1f& residual_px,
                                                     float least_mean_px) {
  std::vector<Sum> sums(obstacles.sizes.size());
  for (int v = 0; v < residual_px.rows; ++v)
    for (int u = 0; u < residual_px.cols; ++u)
      if (const int k = obstacles.number(v, u); k >= 0)
        sums[static_cast<size_t>(k)].add(residual_px(v, u));
  std::vector<std::vector<cv::Point>> shifted;
  for (size_t k = 0; k < sums.size(); ++k)
    if (sums[k].isShift(least_mean_px)) shifted.push_back(obstacles.cellsOf(static_cast<int>(k)));
  return shifted;
}

void AlongChannel::compare(const FrameView& frame, const std::vector<PastFrame>& past) {
  pairs.clear();
  for (size_t k : kFramesBack)
    if (k <= past.size()) pairs.push_back({past[k - 1], past[k / 2 - 1]});
  longResidual(frame.input.rig, frame.cells.disparity_px, frame.range, pairs, kMostParallax_px,
               residual_px, pair);
}

void AlongChannel::find(const FrameView& frame, Verification& verification) const {
  const auto least_mean_px = static_cast<float>(frame.params.dense_min_residual_px);
  // Shifts of single cells are sure from twice the mean of an obstacle on.
  auto groups = groupResiduals(residual_px, pair, frame.cells.disparity_px, least_mean_px);
  for (auto& cells : shiftedObstacles(frame.obstacles, residual_px, 0.5f * least_mean_px))
    groups.push_back(std::move(cells));
  std::stable_sort(groups.begin(), groups.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  const auto hypotheses = firstResults(groups, [&](const auto& cells) -> std::optional<Hypothesis> {
    Hypothesis hypothesis;
    hypothesis.source = Hypothesis::Source::kAlong;
    hypothesis.seeds = pointsOf(frame, cells);
    if (hypothesis.seeds.size() < kFewestPoints) return std::nullopt;
    setLayer(frame, hypothesis);
    if (hypothesis.disparity_px < kLeastDisparity_px) return std::nullopt;
    return hypothesis;
  });
  const auto verify = [&](Hypothesis hypothesis) -> std::optional<VerifiedObject> {
    if (!verification.isFree(hypothesis)) return std::nullopt;
    // An approaching object changes its size too much to be tracked over the longest time: try
    // shorter ones too.
    uint8_t first = kNoPair;  // the oldest pair of any cell
    for (const cv::Point p : hypothesis.seeds) first = std::min(first, pair(p / 2));
    for (size_t k = first; k < pairs.size(); ++k) {
      const PastView view = frame.since(pairs[k].past);
      const auto motion = significantMotion(view, hypothesis.seeds);
      if (!motion) continue;
      hypothesis.moved_m = motion->moved_m;
      hypothesis.covariance = motion->covariance;
      if (auto found = verification.verify(view, cv::Mat1f(), hypothesis)) return found;
    }
    return std::nullopt;
  };
  verification.addAll(frame, hypotheses, verify);
}

}  // namespace predictive_stereo
