#include "detection/road_line.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detection/road_line.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

// Number of samples on a line, within 0.3 px and 3 %.
HWY_NOINLINE int countOnLine(const double* HWY_RESTRICT row,
                             const double* HWY_RESTRICT disparity_px, int count,
                             double horizon_row_px, double disparity_per_row) {
  int64_t on = 0;  // as wide as the compared values, so that compilers can vectorise
  for (int i = 0; i < count; ++i) {
    const double d = disparity_px[i];
    const double error = std::abs(d - disparity_per_row * (row[i] - horizon_row_px));
    on += error < 0.3 + 0.03 * d ? 1 : 0;
  }
  return static_cast<int>(on);
}

}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace predictive_stereo {
namespace {

HWY_EXPORT(countOnLine);

constexpr int kStep_px = 12;
constexpr int kTrials = 80;
constexpr int kBlock = 256;  // samples between checks whether a line can still win
constexpr double kFewestShare = 0.2;
constexpr double kLowestCamera_m = 0.15, kHighestCamera_m = 4;

struct Samples {
  std::vector<double> row, disparity_px;

  int count() const { return static_cast<int>(row.size()); }
};

Samples lowerHalf(const DisparityRange& range, const cv::Mat1f& disparity_px) {
  Samples samples;
  for (int y = disparity_px.rows / 2; y < disparity_px.rows; y += kStep_px / 2)
    for (int x = kStep_px / 2; x < disparity_px.cols; x += kStep_px) {
      const float d = disparity_px(y, x);
      if (!range.isValid(d) || !(d > 0)) continue;
      samples.row.push_back(y);
      samples.disparity_px.push_back(d);
    }
  return samples;
}

// Number of samples on the line if this exceeds `most`; otherwise any number up to `most`.
int countIfMore(const Samples& samples, const RoadLine& line, int most) {
  int on = 0;
  for (int first = 0; first < samples.count(); first += kBlock) {
    const int rest = samples.count() - first;
    if (on + rest <= most) return most;
    on += HWY_DYNAMIC_DISPATCH(countOnLine)(
        &samples.row[static_cast<size_t>(first)], &samples.disparity_px[static_cast<size_t>(first)],
        std::min(kBlock, rest), line.horizon_row_px, line.disparity_per_row);
  }
  return on;
}

}  // namespace

std::optional<RoadLine> fitRoadLine(const StereoRig& rig, const DisparityRange& range,
                                    const cv::Mat1f& disparity_px) {
  const Samples samples = lowerHalf(range, disparity_px);
  const int count = samples.count();
  if (count < 50) return std::nullopt;
  cv::RNG random(1);
  RoadLine best;
  int most = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const auto a = static_cast<size_t>(random.uniform(0, count)),
               b = static_cast<size_t>(random.uniform(0, count));
    const double rows_apart = samples.row[a] - samples.row[b];
    if (std::abs(rows_apart) < 2 * kStep_px) continue;
    RoadLine line;
    line.disparity_per_row = (samples.disparity_px[a] - samples.disparity_px[b]) / rows_apart;
    if (line.disparity_per_row < rig.baseline_m / kHighestCamera_m ||
        line.disparity_per_row > rig.baseline_m / kLowestCamera_m)
      continue;
    line.horizon_row_px = samples.row[a] - samples.disparity_px[a] / line.disparity_per_row;
    const int on = countIfMore(samples, line, most);
    if (on > most) most = on, best = line;
  }
  if (most < kFewestShare * count) return std::nullopt;
  // Least squares over the inliers.
  std::vector<size_t> on_line;
  for (size_t i = 0; i < samples.row.size(); ++i)
    if (HWY_DYNAMIC_DISPATCH(countOnLine)(&samples.row[i], &samples.disparity_px[i], 1,
                                          best.horizon_row_px, best.disparity_per_row) == 1)
      on_line.push_back(i);
  double rows = 0, ds = 0, row_row = 0, row_d = 0;
  const auto n = static_cast<double>(on_line.size());
  for (size_t i : on_line) rows += samples.row[i], ds += samples.disparity_px[i];
  for (size_t i : on_line) {
    const double row = samples.row[i] - rows / n;
    row_row += row * row;
    row_d += row * (samples.disparity_px[i] - ds / n);
  }
  if (!(row_row > 0 && row_d > 0)) return std::nullopt;
  best.disparity_per_row = row_d / row_row;
  best.horizon_row_px = rows / n - ds / n / best.disparity_per_row;
  return best;
}

}  // namespace predictive_stereo
#endif
