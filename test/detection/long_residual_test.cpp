/// Residuals relative to older frames, on walls with known depth and motion.
#include "detection/long_residual.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "detection/depth_cells.h"
#include "detection/frame_comparison.h"
#include "driving_scene.h"
#include "every_target.h"

namespace predictive_stereo {
namespace {

constexpr double kDepth_m = 30;

StereoRig testRig() { return drivingRig({160, 80}); }

/// A wall normal to the line of sight, now at a depth of kDepth_m, which moves ahead at `wall_mps`.
/// The camera moves at kAhead_mps.
class Wall {
 public:
  explicit Wall(double wall_mps) : wall_mps_(wall_mps) {
    for (double seconds : {0.8, 0.4, 0.2, 0.1}) way.remember(seconds, disparityAt(seconds));
  }
  cv::Mat1f disparityAt(double seconds) const {
    const double depth_m = kDepth_m + (kAhead_mps - wall_mps_) * seconds;
    return cv::Mat1f(rig_.size, disparityOf(rig_, depth_m));
  }
  std::vector<PastPair> pairs() const {
    return {{way.past(0.8), way.past(0.4)},
            {way.past(0.4), way.past(0.2)},
            {way.past(0.2), way.past(0.1)}};
  }
  void find(double most_px) {
    const cv::Mat1f cells_px(rig_.size / kCellSide_px, disparityAt(0)(0, 0));
    longResidual(rig_, cells_px, {0, 64}, pairs(), most_px, residual_px, pair);
  }
  /// Disparity of a static wall at that time, minus that of this one.
  double expected(double seconds) const {
    return disparityOf(rig_, kDepth_m + kAhead_mps * seconds) - disparityAt(seconds)(0, 0);
  }

  DrivenWay way;
  cv::Mat1f residual_px;
  cv::Mat1b pair;

 private:
  StereoRig rig_ = testRig();
  double wall_mps_;
};

// Motion [px] of a static point in the image since then, without that of the camera's rotation.
double parallaxSince(const StereoRig& rig, const PastFrame& past, const Eigen::Vector3d& point_px) {
  if (point_px.z() == 0) return 0;  // infinitely far
  const Eigen::Vector3d point_m = rig.pointFromDisparity(point_px.x(), point_px.y(), point_px.z());
  // Relative to the past camera, in the axes of the current one.
  const Eigen::Vector3d seen_m = point_m - past.T_past_cam.inverse().translation();
  if (seen_m.z() <= 0) return std::numeric_limits<double>::infinity();
  return (rig.disparityFromPoint(seen_m) - point_px).head<2>().lpNorm<Eigen::Infinity>();
}

TEST(LongResidual, IsZeroOnWhatStands) {
  Wall wall(0);
  wall.find(16);
  EXPECT_LT(cv::norm(wall.residual_px, cv::NORM_INF), 1e-3);
}

TEST(LongResidual, AddsUpOnWhatDrivesAlong) {
  Wall wall(8);
  wall.find(16);
  // Near the direction of travel the oldest frame is used, because it has the largest residual.
  EXPECT_EQ(wall.pair(10, 20), 0);
  EXPECT_NEAR(wall.residual_px(10, 20), wall.expected(0.8), 0.3);
  EXPECT_LT(wall.residual_px(10, 20), -2);
  EXPECT_LT(std::abs(wall.expected(0.1)), 0.4);
}

TEST(LongResidual, LooksLessFarBackWhereTheWorldHasMovedMore) {
  Wall wall(8);
  wall.find(4);
  int last = 0;
  for (int u = 20; u < 40; ++u) {
    EXPECT_GE(wall.pair(10, u), last) << "column " << 4 * u;
    last = wall.pair(10, u);
    for (int k = 0; k < last; ++k)
      EXPECT_GT(parallaxSince(testRig(), wall.pairs()[static_cast<size_t>(k)].past,
                              {4.0 * u + 2, 42, wall.disparityAt(0)(0, 0)}),
                4);
  }
  EXPECT_GT(last, 0);
}

TEST(LongResidual, NeedsTheFrameHalfwayToAgree) {
  Wall wall(8);
  Wall standing(0);
  wall.way.frame(0.4).disparity_px = standing.disparityAt(0.4);  // like a wrong match in one frame
  wall.find(16);
  EXPECT_NEAR(wall.residual_px(10, 20), 0, 1e-3);
}

TEST(LongResidual, IsUnknownWithoutDisparities) {
  Wall wall(8);
  wall.way.frame(0.8).disparity_px.setTo(-1);
  wall.find(16);
  EXPECT_EQ(wall.residual_px(10, 20), kUnknownResidual);
}

// Reference of longResidual, cell by cell; kNoPair: no suitable pair.
float residualAt(const StereoRig& rig, const cv::Mat1f& cells_px, const DisparityRange& range,
                 const std::vector<PastPair>& pairs, float most_px, cv::Point cell, uchar& pair) {
  const auto x = static_cast<float>(4 * cell.x + 2), y = static_cast<float>(4 * cell.y + 2);
  const float d = cells_px(cell);
  pair = kNoPair;
  if (!(d > 0)) return kUnknownResidual;
  for (size_t k = 0; k < pairs.size() && pair == kNoPair; ++k)
    if (parallaxSince(rig, pairs[k].past, {x, y, d}) <= most_px) pair = static_cast<uchar>(k);
  if (pair == kNoPair) return kUnknownResidual;
  float residual[2];
  for (int i = 0; i < 2; ++i) {
    const PastFrame& then = i == 0 ? pairs[pair].past : pairs[pair].halfway;
    const cv::Mat1f& measured = then.frame->disparity_px;
    const Eigen::Vector3f source = SourceOf(disparityMotion(rig, then.T_past_cam))(x, y, d);
    const float column = source.x() + 0.5f, row = source.y() + 0.5f;
    if (!(source.z() > 0 && column >= 0 && row >= 0 && column < measured.cols &&
          row < measured.rows))
      return kUnknownResidual;
    const float before = measured(static_cast<int>(row), static_cast<int>(column));
    if (!range.isValid(before)) return kUnknownResidual;
    residual[i] = source.z() - before;
  }
  const float far = residual[0];
  const float near =
      residual[1] * static_cast<float>(pairs[pair].past.seconds / pairs[pair].halfway.seconds);
  return near * far <= 0 ? 0.0f : std::abs(near) < std::abs(far) ? near : far;
}

TEST(LongResidual, IsThatOfTheReferenceOnEveryTarget) {
  const DisparityRange range{0, 64};
  for (const cv::Size size :
       {cv::Size(4, 4), cv::Size(10, 8), cv::Size(131, 63), cv::Size(642, 180)}) {
    SCOPED_TRACE(size);
    StereoRig rig = testRig();
    rig.size = size;
    rig.cx_left_px = rig.cx_right_px = 0.4 * size.width;
    cv::RNG rng(size.width);
    const auto world = [&] {
      cv::Mat1f disparity_px(size);
      for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x)
          disparity_px(y, x) = rng.uniform(0, 9) == 0 ? range.invalid()
                                                      : static_cast<float>((x / 40 + y / 30) % 7) *
                                                            rng.uniform(3.0f, 4.0f);
      return disparity_px;
    };
    RememberedFrame frames[4];
    std::vector<PastFrame> past(4);
    for (size_t i = 0; i < past.size(); ++i) {
      frames[i].disparity_px = world();
      past[i].frame = &frames[i];
      past[i].seconds = 0.1 * static_cast<double>(1 + i);
      past[i].T_past_cam.translate(Eigen::Vector3d(0.02, 0.01, 9 * past[i].seconds));
      past[i].T_past_cam.rotate(
          Eigen::AngleAxisd(0.02 * past[i].seconds, Eigen::Vector3d(0, 1, 0)));
    }
    const std::vector<PastPair> pairs = {{past[3], past[1]}, {past[1], past[0]}};
    DepthCells cells;
    const cv::Mat1f now = world();
    cells.setFrame(range, now, now);
    const cv::Mat1f& cells_px = cells.disparity_px;
    forEveryTarget([&] {
      cv::Mat1f residual_px;
      cv::Mat1b pair;
      longResidual(rig, cells_px, range, pairs, 16, residual_px, pair);
      int moving = 0, of_pair[2] = {0, 0};
      for (int v = 0; v < cells_px.rows; ++v)
        for (int u = 0; u < cells_px.cols; ++u) {
          uchar expected_pair;
          const float expected = residualAt(rig, cells_px, range, pairs, 16, {u, v}, expected_pair);
          ASSERT_EQ(residual_px(v, u), expected) << u << ' ' << v;
          ASSERT_EQ(pair(v, u), expected_pair) << u << ' ' << v;
          moving += expected != kUnknownResidual && expected != 0;
          if (expected_pair != kNoPair) ++of_pair[expected_pair];
        }
      if (size.width > 600) {
        EXPECT_GT(std::min({moving, of_pair[0], of_pair[1]}), 300);
      }
    });
  }
}

}  // namespace
}  // namespace predictive_stereo
