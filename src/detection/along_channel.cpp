#include "detection/along_channel.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "detection/constants.h"
#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

// Frames that are compared, if static points have not moved more since then.
constexpr size_t kFramesBack[] = {8, 6, 4, 2};
static_assert(kFramesBack[0] == FrameHistory::kFarthest);

constexpr int kReach = 2;  // residuals are summed over squares of 5x5 points
constexpr uchar kNoSeed = 0, kCandidate = 255;

float orZero(float residual_px) { return residual_px == kUnknownResidual ? 0.0f : residual_px; }

float sumOfSquare(const float* columns_px) {
  static_assert(kReach == 2, "written out");
  return columns_px[0] + columns_px[1] + columns_px[2] + columns_px[3] + columns_px[4];
}

// Whether the residuals of the point's square, whose sum this is, are large and of one sign. The
// image's border cuts squares.
bool isSeed(const cv::Mat1f& residual_px, float least_mean_px, float sum_px, cv::Point at) {
  const float r = residual_px(at);
  if (r == kUnknownResidual || std::abs(r) < 0.5f * least_mean_px) return false;
  const cv::Rect square = cv::Rect(at.x - kReach, at.y - kReach, 2 * kReach + 1, 2 * kReach + 1) &
                          cv::Rect(cv::Point(), residual_px.size());
  int known = 0, signs = 0;
  for (int y = square.y; y < square.br().y; ++y)
    for (int x = square.x; x < square.br().x; ++x) {
      const float other = residual_px(y, x);
      known += other != kUnknownResidual;
      signs += (orZero(other) > 0) - (orZero(other) < 0);
    }
  const auto count = static_cast<float>(known);
  return std::abs(sum_px) >= least_mean_px * count && count >= kFewestKnown &&
         static_cast<float>(std::abs(signs)) >= kLeastSign * count;
}

// Seeds of one value have the same pair and sign.
/// @param unknown_px  a row of unknown points, which stands for those outside the map.
/// @param columns_px  memory for the sums of squares' columns, with kReach zeros at both ends.
void findSeedsOfRow(const cv::Mat1f& residual_px, const cv::Mat1b& pair, float least_mean_px, int v,
                    const float* unknown_px, float* columns_px, uchar* seeds) {
  const auto row = [&](int y) {
    return y < 0 || y >= residual_px.rows ? unknown_px : residual_px[y];
  };
  const float *r0 = row(v - 2), *r1 = row(v - 1), *r2 = row(v), *r3 = row(v + 1), *r4 = row(v + 2);
  const int width = residual_px.cols;
  const float least_sum_px = least_mean_px * kFewestKnown;
  // Loops without a branch, so that the compiler makes vectors of them.
  for (int u = 0; u < width; ++u)
    columns_px[u + kReach] =
        orZero(r0[u]) + orZero(r1[u]) + orZero(r2[u]) + orZero(r3[u]) + orZero(r4[u]);
  for (int u = 0; u < width; ++u)
    seeds[u] = std::abs(sumOfSquare(columns_px + u)) >= least_sum_px ? kCandidate : kNoSeed;
  for (int u = 0; u < width; ++u) {
    const void* const next = std::memchr(seeds + u, kCandidate, static_cast<size_t>(width - u));
    if (!next) break;
    u = static_cast<int>(static_cast<const uchar*>(next) - seeds);
    const float sum_px = sumOfSquare(columns_px + u);
    seeds[u] = isSeed(residual_px, least_mean_px, sum_px, {u, v})
                   ? static_cast<uchar>(2 * pair(v, u) + (sum_px > 0 ? 1 : 2))
                   : kNoSeed;
  }
}

cv::Mat1b findSeeds(const cv::Mat1f& residual_px, const cv::Mat1b& pair, float least_mean_px) {
  cv::Mat1b seeds(residual_px.size());
  parallelFor({0, seeds.rows}, [&](const cv::Range& rows) {
    const cv::Mat1f unknown_px(1, seeds.cols, kUnknownResidual);
    cv::Mat1f columns_px(1, seeds.cols + 2 * kReach, 0.0f);
    for (int v = rows.start; v < rows.end; ++v)
      findSeedsOfRow(residual_px, pair, least_mean_px, v, unknown_px[0], columns_px[0], seeds[v]);
  });
  return seeds;
}

float medianDisparity(const cv::Mat1f& disparity_px, const std::vector<cv::Point>& points) {
  std::vector<float> values;
  for (const cv::Point p : points) values.push_back(disparity_px(2 * p));
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The seeds that are connected to the first one, which are then none any more.
std::vector<cv::Point> takeConnected(const cv::Mat1f& disparity_px, cv::Point first,
                                     cv::Mat1b& seeds) {
  const uchar kind = seeds(first);
  std::vector<cv::Point> open{first}, points;
  seeds(first) = kNoSeed;
  while (!open.empty()) {
    const cv::Point p = open.back();
    open.pop_back();
    points.push_back(p);
    const float d = disparity_px(2 * p);
    for (const cv::Point step : {cv::Point(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
      const cv::Point q = p + step;
      if (!cv::Rect(cv::Point(), seeds.size()).contains(q) || seeds(q) != kind ||
          std::abs(disparity_px(2 * q) - d) > kMostStep_px)
        continue;
      seeds(q) = kNoSeed;
      open.push_back(q);
    }
  }
  return points;
}

void sortByPoints(std::vector<std::vector<cv::Point>>& groups) {
  std::stable_sort(groups.begin(), groups.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
}

}  // namespace

std::vector<std::vector<cv::Point>> groupResiduals(const cv::Mat1f& residual_px,
                                                   const cv::Mat1b& pair,
                                                   const cv::Mat1f& disparity_px,
                                                   float least_mean_px) {
  cv::Mat1b seeds = findSeeds(residual_px, pair, least_mean_px);
  std::vector<std::vector<cv::Point>> groups;
  for (int v = 0; v < seeds.rows; ++v) {
    if (cv::countNonZero(seeds.row(v)) == 0) continue;
    for (int u = 0; u < seeds.cols; ++u) {
      if (seeds(v, u) == kNoSeed) continue;
      std::vector<cv::Point> points = takeConnected(disparity_px, {u, v}, seeds);
      if (points.size() >= kFewestPoints) groups.push_back(std::move(points));
    }
  }
  sortByPoints(groups);
  return groups;
}

std::vector<std::vector<cv::Point>> shiftedObstacles(const Obstacles& obstacles,
                                                     const cv::Mat1f& residual_px,
                                                     const cv::Mat1f& disparity_px,
                                                     const DisparityRange& range,
                                                     float least_mean_px) {
  static_assert(kLongStep_px == kCellSide_px && kLongStep_px == 4, "a cell is 2x2 lattice points");
  struct Residuals {
    float sum_px = 0;
    int cells = 0, signs = 0;
  };
  std::vector<Residuals> residuals(obstacles.sizes.size());
  for (int v = 0; v < obstacles.number.rows; ++v)
    for (int u = 0; u < obstacles.number.cols; ++u) {
      const int k = obstacles.number(v, u);
      const float r = residual_px(2 * v, 2 * u);
      if (k < 0 || r == kUnknownResidual) continue;
      Residuals& of_obstacle = residuals[static_cast<size_t>(k)];
      of_obstacle.sum_px += r;
      ++of_obstacle.cells;
      of_obstacle.signs += (r > 0) - (r < 0);
    }
  std::vector<std::vector<cv::Point>> shifted;
  for (size_t k = 0; k < residuals.size(); ++k) {
    const auto [sum_px, cells, signs] = residuals[k];
    const auto count = static_cast<float>(cells);
    if (cells < kFewestShiftedCells || std::abs(sum_px) < least_mean_px * count ||
        static_cast<float>(std::abs(signs)) < kLeastSign * count)
      continue;
    std::vector<cv::Point> points;
    for (const cv::Point cell : obstacles.cellsOf(static_cast<int>(k)))
      for (const cv::Point step : {cv::Point(0, 0), {1, 0}, {0, 1}, {1, 1}}) {
        const cv::Point p = 2 * cell + step;
        if (residual_px(p) != kUnknownResidual && range.isValid(disparity_px(2 * p)))
          points.push_back(p);
      }
    if (points.size() >= kFewestPoints) shifted.push_back(std::move(points));
  }
  sortByPoints(shifted);
  return shifted;
}

void AlongChannel::compare(const FrameView& frame, const std::vector<PastFrame>& past) {
  pairs.clear();
  for (size_t k : kFramesBack)
    if (k <= past.size()) pairs.push_back({past[k - 1], past[k / 2 - 1]});
  longResidual(frame.input.rig, frame.input.measured_disparity_px, frame.range, pairs,
               kMostParallax_px, frame.lattice(), residual_px, pair);
}

void AlongChannel::find(const FrameView& frame, Verification& verification) const {
  const cv::Mat1f& disparity_px = frame.input.measured_disparity_px;
  const auto least_mean_px = static_cast<float>(frame.params.dense_min_residual_px);
  auto groups = groupResiduals(residual_px, pair, disparity_px, least_mean_px);
  for (auto& points : shiftedObstacles(frame.obstacles, residual_px, disparity_px, frame.range,
                                       kOfObstacle * least_mean_px))
    groups.push_back(std::move(points));
  const auto hypotheses =
      firstResults(kMostAlong, groups, [&](const auto& points) -> std::optional<Hypothesis> {
        if (medianDisparity(disparity_px, points) < kLeastDisparity_px) return std::nullopt;
        Hypothesis hypothesis;
        hypothesis.source = Hypothesis::Source::kAlong;
        hypothesis.seeds = points;
        return hypothesis;
      });
  const auto verify = [&](Hypothesis hypothesis) -> std::optional<VerifiedObject> {
    if (!verification.isFree(hypothesis)) return std::nullopt;
    setLayer(frame, hypothesis);
    // An approaching object changes its size too much to be tracked over the longest time: try
    // shorter ones too.
    for (size_t k = pair(hypothesis.seeds.front()); k < pairs.size(); ++k) {
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
