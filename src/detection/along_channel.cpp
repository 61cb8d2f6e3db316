#include "detection/along_channel.h"

#include <algorithm>
#include <cmath>

#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

// Frames that are compared, if static points have not moved more since then.
constexpr size_t kFramesBack[] = {8, 6, 4, 2};
static_assert(kFramesBack[0] == FrameHistory::kFarthest);
constexpr double kMostParallax_px = 16;
constexpr float kLeastDisparity_px = 10;  // the relative error of smaller ones is too large

constexpr int kReach = 2;           // residuals are summed over squares of 5x5 points
constexpr float kFewestKnown = 15;  // points of a square
constexpr float kLeastSign = 0.8f;  // 90 % of one sign, 10 % of the other
constexpr size_t kFewestPoints = 20;
constexpr float kMostStep_px = 1.5f;  // of the disparity, between neighbours
constexpr uchar kNoSeed = 0;

// One number of each column, and kReach zeros at both ends.
using Columns = std::vector<float>;

// Sums over the columns of the squares around a row: of the points that are known.
struct ColumnSums {
  Columns known, sum_px, signs;

  void reset(int columns) {
    for (Columns* sums : {&known, &sum_px, &signs})
      sums->assign(static_cast<size_t>(columns + 2 * kReach), 0);
  }
};

// Loops without a branch, so that the compiler makes vectors of them.
void addRow(const float* residual_px, int columns, ColumnSums& sums) {
  float *const known = &sums.known[kReach], *const sum_px = &sums.sum_px[kReach],
               *const signs = &sums.signs[kReach];
  for (int u = 0; u < columns; ++u) {
    const float r = residual_px[u] == kUnknownResidual ? 0 : residual_px[u];
    known[u] += residual_px[u] == kUnknownResidual ? 0.0f : 1.0f;
    sum_px[u] += r;
    signs[u] += (r > 0 ? 1.0f : 0.0f) - (r < 0 ? 1.0f : 0.0f);
  }
}

// Replaces the sums of columns by those of squares: the number of column u is at u, not u + kReach.
void sumSquares(Columns& sums) {
  static_assert(kReach == 2);
  float* const s = sums.data();
  for (size_t u = 0; u + 2 * kReach < sums.size(); ++u)
    s[u] = s[u] + s[u + 1] + s[u + 2] + s[u + 3] + s[u + 4];
}

// Points in whose square residuals are large and of one sign. Seeds of one value have the same pair
// and sign. The image's border cuts squares.
void findSeedsOfRow(const cv::Mat1f& residual_px, const cv::Mat1b& pair, float least_mean_px, int v,
                    ColumnSums& sums, uchar* seeds) {
  sums.reset(residual_px.cols);
  for (int y = std::max(v - kReach, 0); y <= std::min(v + kReach, residual_px.rows - 1); ++y)
    addRow(residual_px[y], residual_px.cols, sums);
  for (Columns* columns : {&sums.known, &sums.sum_px, &sums.signs}) sumSquares(*columns);
  for (int u = 0; u < residual_px.cols; ++u) {
    const auto i = static_cast<size_t>(u);
    const float r = residual_px(v, u), known = sums.known[i], sum_px = sums.sum_px[i];
    const bool is_seed = std::abs(sum_px) >= least_mean_px * known &&  // rare: first
                         known >= kFewestKnown && std::abs(sums.signs[i]) >= kLeastSign * known &&
                         r != kUnknownResidual && std::abs(r) >= 0.5f * least_mean_px;
    seeds[u] = is_seed ? static_cast<uchar>(2 * pair(v, u) + (sum_px > 0 ? 1 : 2)) : kNoSeed;
  }
}

cv::Mat1b findSeeds(const cv::Mat1f& residual_px, const cv::Mat1b& pair, float least_mean_px) {
  cv::Mat1b seeds(residual_px.size());
  parallelFor({0, seeds.rows}, [&](const cv::Range& rows) {
    ColumnSums sums;
    for (int v = rows.start; v < rows.end; ++v)
      findSeedsOfRow(residual_px, pair, least_mean_px, v, sums, seeds[v]);
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

}  // namespace

std::vector<ResidualGroup> groupResiduals(const cv::Mat1f& residual_px, const cv::Mat1b& pair,
                                          const cv::Mat1f& disparity_px, float least_mean_px) {
  cv::Mat1b seeds = findSeeds(residual_px, pair, least_mean_px);
  std::vector<ResidualGroup> groups;
  for (int v = 0; v < seeds.rows; ++v)
    for (int u = 0; u < seeds.cols; ++u) {
      if (seeds(v, u) == kNoSeed) continue;
      std::vector<cv::Point> points = takeConnected(disparity_px, {u, v}, seeds);
      if (points.size() < kFewestPoints) continue;
      const float median_px = medianDisparity(disparity_px, points);
      groups.push_back({std::move(points), median_px});
    }
  std::stable_sort(groups.begin(), groups.end(),
                   [](const ResidualGroup& a, const ResidualGroup& b) {
                     return a.points.size() > b.points.size();
                   });
  return groups;
}

void AlongChannel::compare(const FrameView& frame, const std::vector<PastFrame>& past) {
  pairs_.clear();
  for (size_t k : kFramesBack)
    if (k <= past.size()) pairs_.push_back({past[k - 1], past[k / 2 - 1]});
  longResidual(frame.input.rig, frame.input.measured_disparity_px, frame.range, pairs_,
               kMostParallax_px, frame.lattice(), residual_px_, pair_);
}

void AlongChannel::find(const FrameView& frame, Verification& verification) {
  const auto groups = firstResults(
      kMostAlong,
      groupResiduals(residual_px_, pair_, frame.input.measured_disparity_px,
                     static_cast<float>(frame.params.dense_min_residual_px)),
      [](const ResidualGroup& group) {
        return group.disparity_px >= kLeastDisparity_px ? std::optional(group) : std::nullopt;
      });
  verification.addAll(frame, groups, [&](const ResidualGroup& group) {
    return verify(frame, group, verification);
  });
}

std::optional<VerifiedObject> AlongChannel::verify(const FrameView& frame,
                                                   const ResidualGroup& group,
                                                   const Verification& verification) const {
  Hypothesis hypothesis;
  hypothesis.source = Hypothesis::Source::kAlong;
  hypothesis.seeds = group.points;
  if (!verification.isFree(hypothesis)) return std::nullopt;
  setLayer(frame, hypothesis);
  // An approaching object changes its size too much to be tracked over the longest time: try
  // shorter ones too.
  for (size_t k = pair_(group.points.front()); k < pairs_.size(); ++k) {
    const PastView view = frame.since(pairs_[k].past);
    const auto motion = motionOf(view, group.points);
    if (!motion) continue;
    hypothesis.moved_m = motion->moved_m;
    hypothesis.covariance = motion->covariance;
    if (auto found = verification.verify(view, nullptr, hypothesis)) return found;
  }
  return std::nullopt;
}

}  // namespace predictive_stereo
