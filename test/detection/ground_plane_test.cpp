/// Against planes that are known exactly.
#include "detection/ground_plane.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "cell_rig.h"

namespace predictive_stereo {
namespace {

constexpr double kDegree = M_PI / 180;

StereoRig testRig() {
  StereoRig rig;
  rig.size = {322, 240};
  rig.fx_px = 300;
  rig.fy_px = 290;
  rig.cx_left_px = 165;
  rig.cx_right_px = 160;
  rig.cy_px = 118;
  rig.baseline_m = 0.3;
  return rig;
}

// The points with normal . point = distance_m in front of the camera; unknown elsewhere.
cv::Mat1f planeMap(const StereoRig& rig, const Eigen::Vector3d& normal, double distance_m) {
  cv::Mat1f disparity(rig.size, -1.0f);
  for (int y = 0; y < rig.size.height; ++y)
    for (int x = 0; x < rig.size.width; ++x) {
      const Eigen::Vector3d ray((x - rig.cx_left_px) / rig.fx_px, (y - rig.cy_px) / rig.fy_px, 1);
      const double d = rig.disparityTimesDepth() * normal.dot(ray) / distance_m;
      if (d > 0.5) disparity(y, x) = static_cast<float>(d);
    }
  return disparity;
}

// Boards that stand on it, on at least this share of the known pixels.
void putObstacles(double share, cv::Mat1f& disparity) {
  cv::RNG random(11);
  cv::Mat1b covered(disparity.size(), uchar(0));
  while (cv::countNonZero(covered) < share * cv::countNonZero(disparity > 0)) {
    const cv::Rect board(random.uniform(0, disparity.cols - 40), random.uniform(0, disparity.rows),
                         random.uniform(10, 40), random.uniform(20, 60));
    if (board.br().y >= disparity.rows) continue;
    const float foot_px = disparity(board.br().y, board.x + board.width / 2);
    if (foot_px <= 0) continue;
    cv::max(disparity(board), foot_px, disparity(board));
    covered(board) = 255;
  }
}

void addNoise(double sigma_px, cv::Mat1f& disparity) {
  cv::RNG random(5);
  for (float& d : disparity)
    if (d > 0) d += static_cast<float>(random.gaussian(sigma_px));
}

std::optional<GroundPlane> planeIn(const StereoRig& rig, const cv::Mat1f& disparity,
                                   const std::optional<GroundPlane>& last = {}) {
  DepthCells cells;
  cells.setFrame(DisparityRange(), disparity, cv::Mat1f(disparity.size(), 0.1f));
  return findGroundPlane(rig, cells, last);
}

struct Camera {
  const char* name;
  Eigen::Vector3d normal;  // of the ground, downwards, in its frame
  double height_m;
};

const Camera kCameras[] = {
    {"ahead", {0, 1, 0}, 1.6},
    {"down by 50 degrees", {0, std::cos(50 * kDegree), std::sin(50 * kDegree)}, 2.7},
    {"rolled by 10 degrees", {std::sin(10 * kDegree), std::cos(10 * kDegree), 0}, 1.6},
    {"rolled by -10 degrees", {-std::sin(10 * kDegree), std::cos(10 * kDegree), 0}, 1.6},
};

void expectPlane(const StereoRig& rig, const Camera& camera,
                 const std::optional<GroundPlane>& plane, double height_m, double disparity_px,
                 double share = 0) {
  ASSERT_TRUE(plane);
  EXPECT_NEAR(plane->camera_height_m, camera.height_m, height_m);
  const cv::Mat1f truth = planeMap(rig, camera.normal, camera.height_m);
  double worst_px = 0;
  for (int y = 0; y < truth.rows; ++y)
    for (int x = 0; x < truth.cols; ++x)
      if (const float d = truth(y, x); d > 0)
        worst_px = std::max(worst_px, std::abs(plane->disparityAt(x, y) - d) - share * d);
  EXPECT_LT(worst_px, disparity_px);
}

TEST(GroundPlane, IsExactOnAnEmptyPlane) {
  const StereoRig rig = testRig();
  for (const Camera& camera : kCameras) {
    SCOPED_TRACE(camera.name);
    const auto plane = planeIn(rig, planeMap(rig, camera.normal, camera.height_m));
    expectPlane(rig, camera, plane, 1e-4, 1e-3);
  }
}

// Walls that lie on one plane far below the camera are no ground.
TEST(GroundPlane, OfAHighCameraIsMostOfTheView) {
  const StereoRig rig = testRig();
  const Eigen::Vector3d ahead(0, 1, 0);
  for (const double height_m : {1.0, 9.0}) {
    cv::Mat1f disparity = planeMap(rig, ahead, height_m);
    disparity.rowRange(0, rig.size.height - 40) = 30;  // a wall hides most of the plane
    EXPECT_EQ(planeIn(rig, disparity).has_value(), height_m < 5) << height_m;
    EXPECT_TRUE(planeIn(rig, planeMap(rig, ahead, height_m))) << height_m;
  }
}

TEST(GroundPlane, IsFoundBelowObstaclesAndNoise) {
  const StereoRig rig = testRig();
  for (const Camera& camera : kCameras) {
    SCOPED_TRACE(camera.name);
    cv::Mat1f disparity = planeMap(rig, camera.normal, camera.height_m);
    putObstacles(0.3, disparity);
    addNoise(0.1, disparity);
    expectPlane(rig, camera, planeIn(rig, disparity), 0.015 * camera.height_m, 0.2, 0.01);
  }
}

TEST(GroundPlane, GivesTheHeightOfPoints) {
  const StereoRig rig = testRig();
  for (const Camera& camera : kCameras) {
    SCOPED_TRACE(camera.name);
    const auto plane = planeIn(rig, planeMap(rig, camera.normal, camera.height_m));
    ASSERT_TRUE(plane);
    for (const cv::Point cell : {cv::Point(10, 50), {60, 40}, {40, 30}})
      for (const double d : {2.0, 15.0, 80.0}) {
        const Eigen::Vector3d point = rig.pointFromDisparity(4 * cell.x + 2, 4 * cell.y + 2, d);
        EXPECT_NEAR(plane->heightOf(cell, d), camera.height_m - camera.normal.dot(point), 2e-3);
      }
  }
}

// Most of the image is a wall, which a steep plane passes within the tolerance.
TEST(GroundPlane, IsFoundBelowAWall) {
  const StereoRig rig = testRig();
  for (const double wall_m : {10.0, 20.0, 40.0}) {
    SCOPED_TRACE(wall_m);
    cv::Mat1f disparity = planeMap(rig, {0, 1, 0}, 1.6);
    cv::max(disparity, static_cast<float>(rig.disparityTimesDepth() / wall_m), disparity);
    addNoise(0.05, disparity);
    expectPlane(rig, kCameras[0], planeIn(rig, disparity), 0.02, 0.2);
  }
}

TEST(GroundPlane, IsNoneWhereNoGroundIs) {
  const StereoRig rig = testRig();
  EXPECT_FALSE(planeIn(rig, cv::Mat1f(rig.size, -1.0f))) << "sky";
  EXPECT_FALSE(planeIn(rig, planeMap(rig, {0, -1, 0}, 1.2))) << "ceiling";
  for (const double depth_m : {2.0, 4.0, 10.0, 30.0})
    EXPECT_FALSE(planeIn(rig, planeMap(rig, {0, 0, 1}, depth_m))) << "wall at " << depth_m;
  cv::Mat1f noisy = planeMap(rig, {0, 0, 1}, 10);
  addNoise(0.1, noisy);
  EXPECT_FALSE(planeIn(rig, noisy)) << "noisy wall";
  EXPECT_FALSE(planeIn(rig, planeMap(rig, {1, 0, 0}, 2))) << "wall to the right";
}

// A hall whose floor has no texture. Its far end is nearer below than above, by less than the
// errors of its disparities: 1.9 and 2.3 px.
TEST(GroundPlane, IsNoFarWall) {
  const StereoRig rig = testRig();
  cv::Mat1f hall = planeMap(rig, {0, 0.34, 0.94}, 38);
  hall.rowRange(140, hall.rows) = -1;
  addNoise(0.4, hall);
  EXPECT_FALSE(planeIn(rig, hall));
}

// Clutter nearer than a ground of which only every twelfth cell is seen.
cv::Mat1f clutterOn(const cv::Mat1f& ground) {
  cv::RNG random(9);
  cv::Mat1f disparity = ground.clone();
  for (float& d : disparity)
    if (d > 0 && random.uniform(0, 12) > 0) d += random.uniform(6.0f, 60.0f);
  return disparity;
}

TEST(GroundPlane, TheLastPlaneHelpsWhereLittleIsSeen) {
  const StereoRig rig = testRig();
  const Camera& camera = kCameras[0];
  const cv::Mat1f ground = planeMap(rig, camera.normal, camera.height_m);
  const cv::Mat1f clutter = clutterOn(ground);
  ASSERT_FALSE(planeIn(rig, clutter)) << "the test needs a hard case";
  expectPlane(rig, camera, planeIn(rig, clutter, planeIn(rig, ground)), 0.02, 0.2);
}

// The last plane still fits a strip, but most is seen through it.
TEST(GroundPlane, TheLastPlaneIsNoneThatIsSeenThrough) {
  const StereoRig rig = testRig();
  const cv::Mat1f ground = planeMap(rig, {0, 1, 0}, 1.6);
  const auto last = planeIn(rig, ground);
  ASSERT_TRUE(last);
  cv::Mat1f hole(rig.size, -1.0f);
  ground.rowRange(140, 156).copyTo(hole.rowRange(140, 156));
  hole.rowRange(156, 240) = 2;  // farther than the ground
  EXPECT_FALSE(planeIn(rig, hole, last));
}

TEST(GroundPlane, NeedsThirtySamples) {
  const StereoRig rig = testRig();
  const cv::Mat1f ground = planeMap(rig, {0, 1, 0}, 1.6);
  const auto last = planeIn(rig, ground);
  cv::Mat1f few(rig.size, -1.0f);
  const cv::Rect cells(80, 200, 4 * 6, 4 * 5);  // 30 of them
  ground(cells).copyTo(few(cells));
  EXPECT_TRUE(planeIn(rig, few, last));
  few(cv::Rect(80, 200, 4, 4)) = -1;
  EXPECT_FALSE(planeIn(rig, few, last));
}

// A plane below the camera, which rolls.
DepthCells groundAt(double height_m, double roll_deg = 0) {
  const StereoRig rig = cellRig();
  const double roll = roll_deg * M_PI / 180;
  DepthCells cells = unknownCells(0.01f);
  for (int v = 0; v < kCellRows; ++v)
    for (int u = 0; u < kCellColumns; ++u) {
      const double x_px = kCellSide_px * u + kCellCentre_px - rig.cx_left_px,
                   y_px = kCellSide_px * v + kCellCentre_px - rig.cy_px;
      const double below_px = std::cos(roll) * y_px + std::sin(roll) * x_px;
      cells.disparity_px(v, u) =
          static_cast<float>(std::max(0.0, rig.baseline_m * below_px / height_m));
    }
  return cells;
}

TEST(SteadyGround, IsThatOfTwoSuccessiveFrames) {
  SteadyGround ground;
  ground.setFrame(cellRig(), groundAt(1.5));
  EXPECT_FALSE(ground.plane());
  ground.setFrame(cellRig(), groundAt(1.5));
  ASSERT_TRUE(ground.plane());
  EXPECT_NEAR(ground.plane()->camera_height_m, 1.5, 0.01);
  ground.setFrame(cellRig(), groundAt(1.8));
  EXPECT_FALSE(ground.plane()) << "another height";
  ground.setFrame(cellRig(), groundAt(1.7));
  ASSERT_TRUE(ground.plane()) << "within 10 %";
  EXPECT_NEAR(ground.plane()->camera_height_m, 1.7, 0.01) << "of this frame";
  ground.setFrame(cellRig(), groundAt(1.7, 15));
  EXPECT_TRUE(ground.plane());
  ground.setFrame(cellRig(), groundAt(1.7, -10));
  EXPECT_FALSE(ground.plane()) << "another direction";
}

TEST(SteadyGround, EndsWhereNoneIsInView) {
  SteadyGround ground;
  for (int k = 0; k < 2; ++k) ground.setFrame(cellRig(), groundAt(1.5));
  DepthCells wall = groundAt(1.5);
  wall.disparity_px = 20;
  ground.setFrame(cellRig(), wall);
  EXPECT_FALSE(ground.plane());
  ground.setFrame(cellRig(), groundAt(1.5));
  EXPECT_FALSE(ground.plane());
  ground.setFrame(cellRig(), groundAt(1.5));
  EXPECT_TRUE(ground.plane());
  ground.reset();
  EXPECT_FALSE(ground.plane());
  ground.setFrame(cellRig(), groundAt(1.5));
  EXPECT_FALSE(ground.plane());
}

}  // namespace
}  // namespace predictive_stereo
