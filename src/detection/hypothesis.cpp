#include "detection/hypothesis.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "detection/displacement_search.h"

namespace predictive_stereo {
namespace {

// An even sample of lattice points, as pixels.
std::vector<cv::Point> sampleOf(const std::vector<cv::Point>& lattice_points) {
  constexpr size_t kMost = 40;
  std::vector<cv::Point> pixels;
  const size_t step = lattice_points.size() / (kMost + 1) + 1;
  for (size_t i = 0; i < lattice_points.size(); i += step) pixels.push_back(2 * lattice_points[i]);
  return pixels;
}

}  // namespace

void setLayer(const FrameView& frame, Hypothesis& hypothesis) {
  std::vector<float> values;
  for (cv::Point seed : hypothesis.seeds)
    values.push_back(frame.input.measured_disparity_px(2 * seed.y, 2 * seed.x));
  std::sort(values.begin(), values.end());
  const auto quantile = [&](double share) {
    return values[static_cast<size_t>(share * static_cast<double>(values.size() - 1))];
  };
  hypothesis.disparity_px = quantile(0.5);
  const auto fB = static_cast<float>(frame.input.rig.disparityTimesDepth());
  const auto margin_m = static_cast<float>(frame.params.layer_margin_m);
  constexpr float kNoise_px = 1.0f;
  hypothesis.nearest_px = fB / std::max(fB / quantile(0.9) - margin_m, 0.5f) + kNoise_px;
  hypothesis.farthest_px = std::max(fB / (fB / quantile(0.1) + margin_m) - kNoise_px,
                                    static_cast<float>(frame.range.min_disparity));
}

std::optional<Displacement> motionOf(const PastView& view,
                                     const std::vector<cv::Point>& lattice_points) {
  const size_t fewest = static_cast<size_t>(view.params().min_tracks);
  const auto shift = searchShift(view, lattice_points);
  if (!shift) return std::nullopt;
  const auto followed = followPoints(view, sampleOf(lattice_points), shift->shift_px);
  if (followed.size() < fewest) return std::nullopt;
  const Displacement motion = fitDisplacement(view, followed);
  if (motion.inliers.size() < fewest || !motion.isSignificant(view.params())) return std::nullopt;
  return motion;
}

std::optional<Hypothesis> hypothesisOf(const PastView& view, const ObjectTrack& known) {
  constexpr int kLeastArea_px = 100;
  constexpr size_t kFewestSeeds = 8;
  const StereoRig& rig = view.rig();
  const cv::Rect box = known.last.box_px & cv::Rect(cv::Point(), rig.size);
  if (box.area() < kLeastArea_px) return std::nullopt;
  Hypothesis hypothesis;
  hypothesis.source = Hypothesis::Source::kKnown;
  hypothesis.disparity_px = static_cast<float>(rig.disparityTimesDepth() / known.last.centre_m.z());
  const Eigen::Vector3d velocity_mps = known.state.tail<3>();
  hypothesis.moved_m =
      view.past.frame->T_odom_cam.linear().transpose() * velocity_mps * view.past.seconds;
  const float tolerance = 1 + 0.15f * hypothesis.disparity_px;
  for (int v = box.y / 2 + box.height / 8; v < (box.br().y - box.height / 4) / 2; v += 2)
    for (int u = box.x / 2 + box.width / 10; u < (box.br().x - box.width / 5) / 2; u += 2) {
      const float d = view.disparity_px()(2 * v, 2 * u);
      if (view.isKnown(d) && std::abs(d - hypothesis.disparity_px) < tolerance)
        hypothesis.seeds.emplace_back(u, v);
    }
  if (hypothesis.seeds.size() < kFewestSeeds) return std::nullopt;
  setLayer(view.frame, hypothesis);
  return hypothesis;
}

}  // namespace predictive_stereo
