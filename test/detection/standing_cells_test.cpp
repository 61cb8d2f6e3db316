/// Boards on a level road, as maps of cells with exact disparities and with noise.
#include "detection/standing_cells.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/core.hpp>

#include "cell_rig.h"

namespace predictive_stereo {
namespace {

// A level ground below the camera: d = (y - cy) B / h.
GroundPlane levelGround(double camera_height_m) {
  const StereoRig rig = cellRig();
  GroundPlane ground;
  ground.b = rig.baseline_m / camera_height_m;
  ground.c = -rig.cy_px * ground.b;
  ground.camera_height_m = camera_height_m;
  return ground;
}

float disparityOf(double depth_m) {
  return static_cast<float>(cellRig().disparityTimesDepth() / depth_m);
}

// The ground below a far background.
DepthCells road(const GroundPlane& ground) {
  DepthCells cells = unknownCells(0.01f);
  for (int v = 0; v < kCellRows; ++v)
    cells.disparity_px.row(v).setTo(
        std::max(0.5, ground.disparityAt(0, kCellSide_px * v + kCellCentre_px)));
  return cells;
}

void addNoise(double sigma_px, DepthCells& cells) {
  cv::Mat1f error(cells.disparity_px.size());
  cv::RNG(1).fill(error, cv::RNG::NORMAL, 0, sigma_px);
  cells.disparity_px += error;
}

double shareOf(const cv::Mat1b& mask, const cv::Rect& area) {
  return cv::countNonZero(mask(area)) / static_cast<double>(area.area());
}

// A board whose foot is on the ground, at the lower edge of row `last`.
cv::Rect putBoard(const GroundPlane& ground, int last, DepthCells& cells) {
  const cv::Rect board(20, 10, 12, last - 9);
  cells.disparity_px(board).setTo(ground.disparityAt(0, kCellSide_px * (last + 1)));
  return board;
}

TEST(StandingCells, AreAboveTheGround) {
  const GroundPlane ground = levelGround(1.5);
  DepthCells cells = road(ground);
  EXPECT_EQ(cv::countNonZero(cellsAbove(ground, cells).rowRange(25, kCellRows)), 0);
  // A board at 5 m. Its lowest 0.3 m begin at y = 80 + 1.2 * 300 / 5 = 152: between the centres
  // of the rows 37 and 38.
  const cv::Rect board(20, 10, 10, 30);
  cells.disparity_px(board) = disparityOf(5);
  const cv::Mat1b above = cellsAbove(ground, cells);
  EXPECT_EQ(shareOf(above, {20, 10, 10, 28}), 1);
  EXPECT_EQ(shareOf(above, {20, 38, 10, 2}), 0);
  cells.disparity_px.setTo(0);
  EXPECT_EQ(cv::countNonZero(cellsAbove(ground, cells)), 0) << "nothing known";
}

TEST(StandingCells, HaveFeetDownToTheGround) {
  const GroundPlane ground = levelGround(1.5);
  for (const int last : {28, 32, 36}) {
    SCOPED_TRACE(last);
    DepthCells cells = road(ground);
    const cv::Rect board = putBoard(ground, last, cells);
    addNoise(0.05, cells);
    cv::Mat1b standing = cellsAbove(ground, cells);
    const double before = shareOf(standing, board);
    addFeet(ground, cells, standing);
    EXPECT_LT(before, 0.95) << "the test needs a foot";
    EXPECT_GT(shareOf(standing, board), 0.97);
    const cv::Rect road_below(0, last + 2, kCellColumns, kCellRows - last - 2);
    EXPECT_LT(shareOf(standing, road_below), 0.02);
    EXPECT_LT(shareOf(standing, {0, 25, 18, 15}), 0.02) << "beside the board";
  }
}

TEST(StandingCells, WithoutAPlaneAreThoseThatAreNotLevel) {
  for (const double camera_height_m : {0.4, 1.5, 2.5}) {
    SCOPED_TRACE(camera_height_m);
    const GroundPlane ground = levelGround(camera_height_m);
    DepthCells cells = road(ground);
    const cv::Rect board = putBoard(ground, 35, cells);
    addNoise(0.02, cells);
    const cv::Mat1b upright = cellsNotLevel(cellRig(), cells);
    // Near a step, growth is not that of a surface.
    EXPECT_EQ(shareOf(upright, {board.x, board.y, board.width, board.height - 2}), 1);
    EXPECT_LT(shareOf(upright, {0, 28, 18, 10}), 0.02);
    EXPECT_EQ(shareOf(upright, {0, 0, kCellColumns, 20}), 1) << "above the horizon";
  }
}

TEST(StandingCells, WithoutAPlaneAreNotUnknown) {
  DepthCells cells = unknownCells(0);
  EXPECT_EQ(cv::countNonZero(cellsNotLevel(cellRig(), cells)), 0);
  cells.disparity_px.setTo(20.0f);  // a wall
  EXPECT_EQ(shareOf(cellsNotLevel(cellRig(), cells), {0, 0, kCellColumns, kCellRows}), 1);
}

}  // namespace
}  // namespace predictive_stereo
