/// Boards on small maps of cells.
#include "detection/obstacles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "cell_rig.h"

namespace predictive_stereo {
namespace {

float disparityOf(double depth_m) {
  return static_cast<float>(cellRig().disparityTimesDepth() / depth_m);
}

DepthCells emptyCells() { return unknownCells(0.01f); }

Obstacles obstaclesIn(const DepthCells& cells) {
  return findObstacles(cellRig(), cells, std::nullopt);
}

TEST(Obstacles, OneBehindTheOtherAreTwo) {
  DepthCells cells = emptyCells();
  const cv::Rect behind(10, 5, 30, 15), front(20, 12, 10, 20);
  cells.disparity_px(behind) = disparityOf(8);
  cells.disparity_px(front) = disparityOf(5);
  const auto obstacles = obstaclesIn(cells);
  ASSERT_EQ(obstacles.sizes.size(), 2u);
  EXPECT_EQ(cv::boundingRect(obstacles.cellsOf(0)), behind);
  EXPECT_EQ(int(obstacles.sizes[0]), behind.area() - (behind & front).area());
  EXPECT_EQ(cv::boundingRect(obstacles.cellsOf(1)), front);
  EXPECT_EQ(int(obstacles.sizes[1]), front.area());
  const std::vector<cv::Point> first = obstacles.cellsOf(0);
  EXPECT_EQ(int(first.size()), obstacles.sizes[0]);
  EXPECT_TRUE(std::is_sorted(first.begin(), first.end(), [](cv::Point a, cv::Point b) {
    return std::pair(a.y, a.x) < std::pair(b.y, b.x);
  }));
}

TEST(Obstacles, ASlantedSideIsOne) {
  DepthCells cells = emptyCells();
  const cv::Rect side(10, 10, 26, 10);
  for (int u = side.x; u < side.br().x; ++u)  // from 6 to 10.5 m
    cells.disparity_px.col(u).rowRange(10, 20) =
        disparityOf(6 + 4.5 * (u - side.x) / (side.width - 1));
  const auto obstacles = obstaclesIn(cells);
  ASSERT_EQ(obstacles.sizes.size(), 1u);
  EXPECT_EQ(cv::boundingRect(obstacles.cellsOf(0)), side);
  EXPECT_EQ(int(obstacles.sizes[0]), side.area());
}

// Steps of 0.3 m and of 1 px are the same surface, if two standard deviations are within them.
TEST(Obstacles, EndAtAStep) {
  const auto countAt = [](float d, float e, float variance_px2, float camera_pixel_px = 1) {
    DepthCells cells = emptyCells();
    cells.variance_px2 = variance_px2;
    cells.disparity_px(cv::Rect(10, 10, 8, 8)) = d;
    cells.disparity_px(cv::Rect(18, 10, 8, 8)) = e;
    return int(findObstacles(cellRig(), cells, std::nullopt, camera_pixel_px).sizes.size());
  };
  // 0.3 m / 90 px m * (40 px)^2 = 5.33 px.
  EXPECT_EQ(countAt(40, 34.8f, 0), 1);
  EXPECT_EQ(countAt(34.8f, 40, 0), 1);
  EXPECT_EQ(countAt(40, 34.5f, 0), 2);
  EXPECT_EQ(countAt(8, 7.1f, 0), 1);
  EXPECT_EQ(countAt(8, 6.9f, 0), 2);
  EXPECT_EQ(countAt(8, 7.6f, 0.04f), 1);  // 0.4 px, and 2 sqrt(2) 0.2 px
  EXPECT_EQ(countAt(8, 7.6f, 0.05f), 2);
  // Pixels of the camera: those of an enlarged image are half of them.
  EXPECT_EQ(countAt(8, 6.1f, 0, 2), 1);
  EXPECT_EQ(countAt(8, 5.9f, 0, 2), 2);
}

TEST(Obstacles, EndAtNoise) {
  DepthCells cells = emptyCells();
  const cv::Rect board(10, 10, 8, 8), noise(10, 18, 20, 3);
  for (const cv::Rect& part : {board, noise}) cells.disparity_px(part) = 8;
  ASSERT_EQ(obstaclesIn(cells).sizes.size(), 1u);
  cells.variance_px2(noise) = 0.3f;
  const auto obstacles = obstaclesIn(cells);
  ASSERT_GT(obstacles.sizes.size(), 1u);
  EXPECT_EQ(cv::boundingRect(obstacles.cellsOf(0)), board);
}

TEST(Obstacles, ReachOverAGapOfOneCell) {
  for (const bool across : {true, false})
    for (const int gap : {1, 2}) {
      SCOPED_TRACE(testing::Message() << gap << (across ? " columns" : " rows"));
      DepthCells cells = emptyCells();
      const cv::Rect board(10, 10, 20, 20);
      cells.disparity_px(board) = disparityOf(6);
      cells.disparity_px(across ? cv::Rect(20, 10, gap, 20) : cv::Rect(10, 20, 20, gap)) = 0;
      const auto obstacles = obstaclesIn(cells);
      ASSERT_EQ(int(obstacles.sizes.size()), gap);
      if (gap == 1) {
        EXPECT_EQ(cv::boundingRect(obstacles.cellsOf(0)), board);
      }
    }
}

TEST(Obstacles, TouchAtACorner) {
  DepthCells cells = emptyCells();
  cells.disparity_px(cv::Rect(10, 10, 5, 5)) = 15;
  cells.disparity_px(cv::Rect(15, 15, 5, 5)) = 15;
  cells.disparity_px(cv::Rect(5, 20, 5, 5)) = 15;  // apart
  EXPECT_EQ(obstaclesIn(cells).sizes.size(), 2u);
  cells.disparity_px(cv::Rect(10, 15, 1, 5)) = 15;
  EXPECT_EQ(obstaclesIn(cells).sizes.size(), 1u);
}

TEST(Obstacles, StandAtLatticePoints) {
  DepthCells cells = emptyCells();
  cells.disparity_px(cv::Rect(kCellColumns - 1, 10, 1, 5)) = 15;
  const auto obstacles = obstaclesIn(cells);
  const int right = 2 * kCellColumns;  // lattice point of an image that is wider than its cells
  ASSERT_EQ(obstacles.standing.size(), cells.lattice_px.size());
  EXPECT_EQ(cv::countNonZero(obstacles.standing), 3 * 10);
  EXPECT_TRUE(obstacles.standing({right - 2, 20}));
  EXPECT_TRUE(obstacles.standing({right, 29}));
}

TEST(Obstacles, AreAboveTheGround) {
  const StereoRig rig = cellRig();
  // A level ground 1.5 m below the camera: d = (y - cy) B / h.
  GroundPlane ground;
  ground.b = rig.baseline_m / 1.5;
  ground.c = -rig.cy_px * ground.b;
  ground.camera_height_m = 1.5;
  DepthCells cells = emptyCells();
  for (int v = 0; v < 40; ++v)
    cells.disparity_px.row(v) = std::max(0.0, ground.disparityAt(0, 4 * v + 2));
  EXPECT_EQ(findObstacles(rig, cells, ground).sizes.size(), 0u);
  // A board at 5 m, whose foot is at y = 80 + 1.5 * 300 / 5 = 170: outside the image. Its lowest
  // 0.3 m begin at y = 152, which is between the centres of the rows 37 and 38.
  const cv::Rect board(20, 10, 10, 30);
  cells.disparity_px(board) = disparityOf(5);
  const auto obstacles = findObstacles(rig, cells, ground);
  ASSERT_EQ(obstacles.sizes.size(), 1u);
  EXPECT_EQ(cv::boundingRect(obstacles.cellsOf(0)), cv::Rect(20, 10, 10, 28));
}

// Width [px] of the obstacle in a cell.
float widthAt(const DepthCells& cells, cv::Point cell) {
  return obstacleWidths(obstaclesIn(cells), cells)(cell);
}

TEST(ObstacleWidths, AreThoseOfTheThickestPlace) {
  DepthCells cells = emptyCells();
  cells.disparity_px = disparityOf(40);
  cells.disparity_px(cv::Rect(10, 5, 1, 30)) = disparityOf(6);  // a pole
  EXPECT_EQ(widthAt(cells, {10, 20}), 4);
  cells.disparity_px(cv::Rect(20, 5, 9, 30)) = disparityOf(6);  // a board
  EXPECT_EQ(widthAt(cells, {10, 20}), 4);
  EXPECT_EQ(widthAt(cells, {20, 20}), 36);
  EXPECT_EQ(widthAt(cells, {24, 5}), 36) << "the same in all its cells";
  // A sign, 5 cells wide, on the pole.
  cells.disparity_px(cv::Rect(8, 5, 5, 5)) = disparityOf(6);
  EXPECT_EQ(widthAt(cells, {10, 30}), 20);
}

TEST(ObstacleWidths, OfAnImageNarrowerThanACellAreNone) {
  DepthCells cells;
  cells.disparity_px = cells.variance_px2 = cv::Mat1f(40, 0);
  EXPECT_EQ(obstaclesIn(cells).sizes.size(), 0u);
  EXPECT_EQ(obstacleWidths(obstaclesIn(cells), cells).size(), cv::Size(0, 40));
}

TEST(ObstacleWidths, AreLargeOnTheGround) {
  DepthCells cells = emptyCells();
  cells.disparity_px(cv::Rect(10, 5, 5, 10)) = 15;
  EXPECT_GT(widthAt(cells, {30, 20}), 1e5);
  EXPECT_EQ(widthAt(cells, {12, 10}), 20);
}

TEST(ObstacleWidths, OfAPartlyHiddenBoardAreNotThoseOfItsVisiblePart) {
  DepthCells cells = emptyCells();
  const cv::Rect board(20, 5, 11, 30), seen(20, 5, 4, 30);
  cells.disparity_px = disparityOf(40);
  cells.disparity_px(seen) = disparityOf(8);
  const float visible_px = widthAt(cells, {21, 20});
  EXPECT_EQ(visible_px, 12);  // 4 cells; the largest square around a cell has 3
  // Now it goes on behind a nearer board.
  cells.disparity_px(cv::Rect(24, 0, 20, 40)) = disparityOf(4);
  EXPECT_EQ(widthAt(cells, {21, 20}), 20);
  // A nearer pole hides its middle.
  cells.disparity_px = disparityOf(40);
  cells.disparity_px(board) = disparityOf(8);
  EXPECT_EQ(widthAt(cells, {21, 20}), 44);
  cells.disparity_px(cv::Rect(25, 0, 1, 40)) = disparityOf(4);
  EXPECT_GE(widthAt(cells, {21, 20}), 20);
  EXPECT_GE(widthAt(cells, {29, 20}), 20);
}

}  // namespace
}  // namespace predictive_stereo
