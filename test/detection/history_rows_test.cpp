/// Costs and gains of points against a plain reference, on every SIMD target.
#include "detection/history_rows.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <optional>
#include <vector>

#include "detection/frame_comparison.h"
#include "driving_scene.h"

namespace predictive_stereo {
namespace {

const CostLimits kLimits{0.5f, 0.015f, 9, 4.5f, 0};

// A world of patches with holes.
cv::Mat1f world(cv::Size size, int seed) {
  cv::RNG rng(seed);
  cv::Mat1f disparity(size);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x)
      disparity(y, x) = rng.uniform(0, 9) == 0 ? -1.0f
                                               : 4 * static_cast<float>((x / 40 + y / 30) % 7) +
                                                     rng.uniform(0.0f, 1.0f);
  return disparity;
}

float errorOf(float expected, float measured) {
  return (measured - expected) / (kLimits.sigma_px + kLimits.sigma_per_disparity * expected);
}

// What was measured at the nearest pixel.
std::optional<float> measuredAt(const Eigen::Vector3f& at, const cv::Mat1f& past) {
  const float column = at.x() + 0.5f, row = at.y() + 0.5f;
  if (!(at.z() > 0 && column >= 0 && row >= 0 && column < static_cast<float>(past.cols) &&
        row < static_cast<float>(past.rows)))
    return std::nullopt;
  const float measured = past(static_cast<int>(row), static_cast<int>(column));
  return measured >= 0 ? std::optional(measured) : std::nullopt;
}

std::optional<float> costOf(const Eigen::Vector3f& at, const cv::Mat1f& past) {
  const auto measured = measuredAt(at, past);
  if (!measured) return std::nullopt;
  const float error = errorOf(at.z(), *measured);
  if (error * error < kLimits.most) return error * error;
  if (error > 0) return std::nullopt;  // something nearer hides it
  return kLimits.most;                 // one sees through it
}

std::optional<float> gainOf(const Eigen::Vector3f& still, const Eigen::Vector3f& moved,
                            const cv::Mat1f& past) {
  const auto by_object = costOf(moved, past);
  const auto measured = measuredAt(still, past);
  if (!by_object || !measured) return std::nullopt;
  const float error = errorOf(still.z(), *measured), of_object = errorOf(moved.z(), *measured);
  if (error * error < kLimits.most) return error * error - *by_object;
  // What hides a static point may be the object itself, which has its disparity.
  if (error > 0 && of_object * of_object > kLimits.most) return std::nullopt;
  return kLimits.most - *by_object;
}

TEST(HistoryRows, AreThoseOfTheReference) {
  const StereoRig rig = drivingRig({300, 90});
  const cv::Mat1f now = world(rig.size, 1), past = world(rig.size, 2);
  Eigen::Isometry3d T_still = Eigen::Isometry3d::Identity(), T_moved = T_still;
  T_still.translation() = Eigen::Vector3d(0.05, 0, 2.5);
  T_moved.translation() = Eigen::Vector3d(-0.1, 0, 1.2);
  const SourceOf still(disparityMotion(rig, T_still)), moved(disparityMotion(rig, T_moved));
  const PastDisparities then{moved.H().data(), past[0], static_cast<int>(past.step1()), past.cols,
                             past.rows};
  int hidden = 0, seen_through = 0, gained = 0, lost = 0;
  for (const int count : {0, 1, 7, 63, 64, 65, 900}) {
    SCOPED_TRACE(count);
    cv::RNG rng(count);
    std::vector<float> x, y, d;
    for (int i = 0; i < count; ++i) {
      const int px = rng.uniform(0, rig.size.width), py = rng.uniform(0, rig.size.height);
      x.push_back(static_cast<float>(px));
      y.push_back(static_cast<float>(py));
      d.push_back(std::max(now(py, px), 0.1f));
    }
    for (auto targets = hwy::SupportedTargets(); targets; targets &= targets - 1) {
      hwy::SetSupportedTargetsForTest(targets & ~(targets - 1));
      std::vector<float> cost(x.size(), -7.0f), gain(x.size(), -7.0f);
      std::vector<uint8_t> known(x.size(), 7);
      const PointRow points{x.data(), y.data(), d.data(), count};
      costRow(points, then, kLimits, cost.data());
      gainRow(points, still.H().data(), then, kLimits, gain.data(), known.data());
      for (size_t i = 0; i < x.size(); ++i) {
        const Eigen::Vector3f source = moved(x[i], y[i], d[i]);
        const auto expected = costOf(source, past);
        const auto expected_gain = gainOf(still(x[i], y[i], d[i]), source, past);
        ASSERT_EQ(cost[i], expected.value_or(kLimits.unknown)) << i;
        ASSERT_EQ(known[i], expected_gain.has_value()) << i;
        ASSERT_EQ(gain[i], expected_gain.value_or(0)) << i;
        hidden += !expected;
        seen_through += expected == kLimits.most;
        gained += expected_gain.value_or(0) > 0;
        lost += expected_gain.value_or(0) < 0;
      }
    }
    hwy::SetSupportedTargetsForTest(0);
  }
  EXPECT_GT(std::min({hidden, seen_through, gained, lost}), 50);
}

}  // namespace
}  // namespace predictive_stereo
