/// Velocities from the disparities of past frames, of a board before a wall, all of them known.
#include "detection/layer_motion.h"

#include <gtest/gtest.h>

#include <random>

#include "driving_scene.h"

namespace predictive_stereo {
namespace {

using Eigen::Vector3d;

constexpr double kDepth_m = 20, kWall_m = 45;
constexpr double kWidth_m = 0.6, kHeight_m = 1.6;
const DisparityRange kRange{0, 64};

/// A board as wide as a cyclist, 20 m away now, before a wall; the camera drives at 8 m/s.
class Scene {
 public:
  /// @param noise_px  standard deviation of each disparity, the same in all its 3x3 pixels.
  Scene(const Vector3d& velocity_mps, double noise_px, int past_frames = 8)
      : velocity_mps_(velocity_mps) {
    std::mt19937 random(7);
    std::normal_distribution<float> noise(0, static_cast<float>(noise_px));
    for (int k = 0; k <= past_frames; ++k) {
      cv::Mat1f map = trueDisparity(0.1 * k);
      for (int y = 0; y < map.rows; y += 3)
        for (int x = 0; x < map.cols; x += 3)
          map(cv::Rect(x, y, 3, 3) & cv::Rect({}, map.size())) += noise(random);
      if (k == 0)
        disparity_px_ = map;
      else
        way_.remember(0.1 * k, map);
    }
  }
  DisparityHistory history() const { return {rig_, kRange, disparity_px_, way_.all()}; }
  /// Where the board was, in the camera's frame of then.
  cv::Rect boardAt(double seconds) const {
    const Vector3d centre =
        Vector3d(0, 0, kDepth_m + kAhead_mps * seconds) - velocity_mps_ * seconds;
    const double scale = rig_.fx_px / centre.z();
    return {cv::Point(cvRound(rig_.cx_left_px + scale * (centre.x() - kWidth_m / 2)),
                      cvRound(rig_.cy_px - scale * kHeight_m / 2)),
            cv::Size(cvRound(scale * kWidth_m), cvRound(scale * kHeight_m))};
  }
  std::vector<cv::Point> pointsOf(const cv::Rect& box) const {
    std::vector<cv::Point> points;
    for (int y = box.y + 2; y < box.br().y - 2; y += 6)
      for (int x = box.x + 2; x < box.br().x - 2; x += 4) points.emplace_back(x, y);
    return points;
  }

 private:
  cv::Mat1f trueDisparity(double seconds) const {
    cv::Mat1f map(rig_.size, disparityOf(rig_, kWall_m + kAhead_mps * seconds));
    const double board_m = kDepth_m + (kAhead_mps - velocity_mps_.z()) * seconds;
    map(boardAt(seconds) & cv::Rect({}, rig_.size)).setTo(disparityOf(rig_, board_m));
    return map;
  }

  StereoRig rig_ = drivingRig({320, 120});
  Vector3d velocity_mps_;
  cv::Mat1f disparity_px_;
  DrivenWay way_;
};

class MovingBoard : public testing::TestWithParam<Vector3d> {};

TEST_P(MovingBoard, HasItsVelocity) {
  const Scene scene(GetParam(), 0.3);
  const auto motion = scene.history().fit(scene.pointsOf(scene.boardAt(0)));
  ASSERT_TRUE(motion);
  EXPECT_NEAR(motion->velocity_mps.x(), GetParam().x(), 0.5);
  EXPECT_NEAR(motion->velocity_mps.z(), GetParam().z(), 0.7);
  EXPECT_EQ(motion->velocity_mps.y(), 0);
  EXPECT_GT(motion->gain, 2);
  EXPECT_LT(motion->cost, 1.5);
  EXPECT_GT(motion->known, 0.5);
  const Vector3d error = motion->velocity_mps - GetParam();
  EXPECT_LT(error.dot(motion->covariance.inverse() * error), 16);
}

INSTANTIATE_TEST_SUITE_P(LayerMotion, MovingBoard,
                         testing::Values(Vector3d(0, 0, 4), Vector3d(0, 0, 9), Vector3d(0, 0, -5),
                                         Vector3d(1, 0, 4), Vector3d(-2, 0, 3)));

TEST(LayerMotion, IsNoneOfWhatStands) {
  const Scene scene(Vector3d::Zero(), 0.3);
  const auto motion = scene.history().fit(scene.pointsOf(scene.boardAt(0)));
  ASSERT_TRUE(motion);
  EXPECT_LT(motion->velocity_mps.norm(), 1);
  EXPECT_LT(motion->gain, 0.5);
}

TEST(LayerMotion, IsNoneOfAWallThatTheBoardUncovers) {
  const Scene scene({2, 0, 4}, 0.3);
  const cv::Rect now = scene.boardAt(0), before = scene.boardAt(0.4);
  ASSERT_LT(before.x, now.x - 8);
  const cv::Rect uncovered(before.x, now.y + 8, now.x - before.x - 2, now.height - 16);
  const auto motion = scene.history().fit(scene.pointsOf(uncovered));
  ASSERT_TRUE(motion);
  EXPECT_LT(motion->gain, 0.5);
}

TEST(LayerMotion, StaysNearWhatIsExpected) {
  const Scene scene({0, 0, 4}, 0.3);
  const auto points = scene.pointsOf(scene.boardAt(0));
  const auto near = scene.history().fit(points, Vector3d(0.3, 0, 5));
  ASSERT_TRUE(near);
  EXPECT_NEAR(near->velocity_mps.z(), 4, 0.7);
  const auto far = scene.history().fit(points, Vector3d(0, 0, -15));
  ASSERT_TRUE(far);
  EXPECT_LT(far->velocity_mps.z(), -8);
}

TEST(LayerMotion, IsUnknownWithoutAPast) {
  const Scene scene({0, 0, 4}, 0, 0);
  EXPECT_FALSE(scene.history().fit(scene.pointsOf(scene.boardAt(0))));
}

TEST(LayerMotion, GainsWhereTheBoardIs) {
  const Scene scene({0, 0, 4}, 0);
  const cv::Rect board = scene.boardAt(0);
  cv::Mat1f sum(60, 160, 0.0f);
  scene.history().addGain({0, 0, 160, 60}, {0, 0, 4}, 2, sum);
  EXPECT_GT(sum((board.y + board.height / 2) / 2, (board.x + board.width / 2) / 2), 4);
  EXPECT_LE(sum(30, 140), 0);  // the wall
  for (float gain : sum) EXPECT_LE(std::abs(gain), 2 * DisparityHistory::kMostCost);
}

}  // namespace
}  // namespace predictive_stereo
