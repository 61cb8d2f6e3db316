#include "detection/road_line.h"

#include <cmath>
#include <vector>

namespace predictive_stereo {
namespace {

constexpr int kStep_px = 12;
constexpr int kTrials = 80;
constexpr double kFewestShare = 0.2;
constexpr double kLowestCamera_m = 0.15, kHighestCamera_m = 4;

}  // namespace

std::optional<RoadLine> fitRoadLine(const StereoRig& rig, const DisparityRange& range,
                                    const cv::Mat1f& disparity_px) {
  struct Sample {
    double row, d;
  };
  std::vector<Sample> samples;
  for (int y = disparity_px.rows / 2; y < disparity_px.rows; y += kStep_px / 2)
    for (int x = kStep_px / 2; x < disparity_px.cols; x += kStep_px) {
      const float d = disparity_px(y, x);
      if (range.isValid(d) && d > 0) samples.push_back({double(y), d});
    }
  const auto count = static_cast<int>(samples.size());
  if (count < 50) return std::nullopt;
  const auto isOn = [](const RoadLine& line, const Sample& s) {
    const double d = line.disparity_per_row * (s.row - line.horizon_row_px);
    return std::abs(s.d - d) < 0.3 + 0.03 * s.d;
  };
  cv::RNG random(1);
  RoadLine best;
  int most = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Sample &a = samples[random.uniform(0, count)], &b = samples[random.uniform(0, count)];
    if (std::abs(a.row - b.row) < 2 * kStep_px) continue;
    RoadLine line;
    line.disparity_per_row = (b.d - a.d) / (b.row - a.row);
    if (line.disparity_per_row < rig.baseline_m / kHighestCamera_m ||
        line.disparity_per_row > rig.baseline_m / kLowestCamera_m)
      continue;
    line.horizon_row_px = a.row - a.d / line.disparity_per_row;
    int on = 0;
    for (const Sample& s : samples) on += isOn(line, s);
    if (on > most) most = on, best = line;
  }
  if (most < kFewestShare * count) return std::nullopt;
  // Least squares over what lies on it.
  double rows = 0, ds = 0, n = 0, row_row = 0, row_d = 0;
  for (const Sample& s : samples)
    if (isOn(best, s)) rows += s.row, ds += s.d, ++n;
  for (const Sample& s : samples)
    if (isOn(best, s))
      row_row += (s.row - rows / n) * (s.row - rows / n),
          row_d += (s.row - rows / n) * (s.d - ds / n);
  if (!(row_row > 0 && row_d > 0)) return std::nullopt;
  best.disparity_per_row = row_d / row_row;
  best.horizon_row_px = rows / n - ds / n / best.disparity_per_row;
  return best;
}

}  // namespace predictive_stereo
