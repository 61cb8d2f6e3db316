/// A board before a wall, with exact disparities: each cell's evidence is known.
#include "detection/free_space.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <random>
#include <vector>

#include "detection/board_scene.h"
#include "detection/constants.h"
#include "every_target.h"

namespace predictive_stereo {
namespace {

constexpr float kWide_px = 1e6f;

// A board of 72 x 96 pixels at (124, 72), 4 m away; the wall is 10 m away.
Board boardAt4m() { return {-0.48, -0.64, 0.96, 1.28, 4}; }
const cv::Rect kBoardCells(31, 18, 18, 24);
BoardScene emptyScene() { return {{wallAt(10)}}; }
BoardScene boardScene() { return {{wallAt(10), boardAt4m()}}; }

class FreeSpaceTest : public testing::Test {
 protected:
  const FreeSpaceEvidence& compare(const BoardView& view, float width_px = kWide_px) {
    cells_.setFrame(DisparityRange(), view.input.measured_disparity_px,
                    view.input.measured_variance_px2);
    space_.compare(view.input, cells_, view.half_image,
                   cv::Mat1f(cells_.disparity_px.size(), width_px));
    return space_.evidence();
  }
  void remember(const BoardView& view) {
    cells_.setFrame(DisparityRange(), view.input.measured_disparity_px,
                    view.input.measured_variance_px2);
    space_.remember(view.input, cells_, view.half_image);
  }
  // Remembers a static view at 10 Hz, up to 0.1 s before time 0.
  void rememberStatic(BoardView view, int count = 6) {
    for (int k = count; k > 0; --k) {
      view.input.stamp_s = -0.1 * k;
      remember(view);
    }
  }
  FreeSpace space_;
  DepthCells cells_;
};

// 255 in the rectangle of cells, 0 elsewhere.
cv::Mat1b cellsIn(const cv::Rect& area) {
  cv::Mat1b expected(60, 80, uchar(0));
  expected(area) = 255;
  return expected;
}

void expectNothing(const FreeSpaceEvidence& evidence) {
  EXPECT_EQ(cv::countNonZero(evidence.moved), 0);
  EXPECT_EQ(cv::countNonZero(evidence.fixed), 0);
}

TEST_F(FreeSpaceTest, ABoardThatAppearsHasMoved) {
  rememberStatic(viewOf(emptyScene(), 0));
  const FreeSpaceEvidence& evidence = compare(viewOf(boardScene(), 0));
  const cv::Mat1b expected = cellsIn(kBoardCells);
  EXPECT_EQ(cv::countNonZero(evidence.moved != expected), 0);
  EXPECT_EQ(cv::countNonZero(evidence.fixed == expected), 0) << "the wall, and only it";
}

TEST_F(FreeSpaceTest, ABoardThatAlwaysStoodThereIsFixed) {
  rememberStatic(viewOf(boardScene(), 0));
  const FreeSpaceEvidence& evidence = compare(viewOf(boardScene(), 0));
  EXPECT_EQ(cv::countNonZero(evidence.moved), 0);
  EXPECT_EQ(cv::countNonZero(evidence.fixed), 60 * 80);
}

TEST_F(FreeSpaceTest, WhatWasHiddenIsNeither) {
  rememberStatic(viewOf(boardScene(), 0));
  const FreeSpaceEvidence& evidence = compare(viewOf(emptyScene(), 0));
  EXPECT_EQ(cv::countNonZero(evidence.moved), 0);
  const cv::Rect inner(kBoardCells.x + 1, kBoardCells.y + 1, kBoardCells.width - 2,
                       kBoardCells.height - 2);
  EXPECT_EQ(cv::countNonZero(evidence.fixed(inner)), 0);
  EXPECT_EQ(cv::countNonZero(evidence.fixed | cellsIn(kBoardCells)), 60 * 80);
}

TEST_F(FreeSpaceTest, UnknownDisparitiesAreNeither) {
  BoardView past = viewOf(emptyScene(), 0), now = viewOf(boardScene(), 0);
  past.input.measured_disparity_px.colRange(0, 160) = -1;
  rememberStatic(past);
  now.input.measured_disparity_px.rowRange(120, 240) = -1;
  const FreeSpaceEvidence& evidence = compare(now);
  const cv::Rect known(39, 0, 41, 30);  // 3x3 lattice points around a cell of the border are known
  EXPECT_EQ(cv::countNonZero(evidence.moved != cellsIn(kBoardCells & known)), 0);
  EXPECT_EQ(cv::countNonZero((evidence.moved | evidence.fixed) != cellsIn(known)), 0);
}

TEST_F(FreeSpaceTest, AWrongDisparityIsRefutedByTheImage) {
  rememberStatic(viewOf(emptyScene(), 0));
  BoardView wrong = viewOf(emptyScene(), 0);
  viewOf(boardScene(), 0).input.measured_disparity_px.copyTo(wrong.input.measured_disparity_px);
  const FreeSpaceEvidence& evidence = compare(wrong);
  EXPECT_EQ(cv::countNonZero(evidence.moved), 0);
  EXPECT_EQ(cv::countNonZero(evidence.fixed(kBoardCells)), 0);
}

// The wall's place in the past image depends on its disparity there.
TEST_F(FreeSpaceTest, AWrongDisparityIsRefutedWhileTheCameraMoves) {
  Eigen::Isometry3d T_odom_cam = Eigen::Isometry3d::Identity();
  for (int k = 0; k < 6; ++k) {
    T_odom_cam.translation() = Eigen::Vector3d(0.2 * k, 0, 0.1 * k);
    if (k < 5) remember(viewOf(emptyScene(), 0.1 * k, T_odom_cam));
  }
  BoardView wrong = viewOf(emptyScene(), 0.5, T_odom_cam);
  wrong.input.measured_disparity_px(cv::Rect(120, 80, 60, 80)) = 22.5f;
  EXPECT_EQ(cv::countNonZero(compare(wrong).moved), 0);
}

TEST_F(FreeSpaceTest, APoleThatWasNotMeasuredIsRefutedByThePastImage) {
  const Board pole{-0.1, -1.2, 0.2, 2.4, 4};
  const BoardScene scene{{wallAt(10), pole}};
  for (const double step_m : {0.0, 0.05}) {
    SCOPED_TRACE(step_m);
    space_.reset();
    Eigen::Isometry3d T_odom_cam = Eigen::Isometry3d::Identity();
    for (int k = 0; k < 6; ++k) {
      T_odom_cam.translation().x() = step_m * (k - 5);
      BoardView view = viewOf(scene, 0.1 * k, T_odom_cam);
      EXPECT_EQ(cv::countNonZero(compare(view).moved), 0) << k;
      view.input.measured_disparity_px = 9;  // the wall alone
      remember(view);
    }
  }
}

TEST_F(FreeSpaceTest, WhatThePastMatcherCouldNotSeeIsNoEvidence) {
  rememberStatic(viewOf(emptyScene(), 0));
  EXPECT_EQ(cv::countNonZero(compare(viewOf(boardScene(), 0), 17.9f).moved), 0);
  EXPECT_EQ(cv::countNonZero(compare(viewOf(boardScene(), 0), 18.1f).moved), kBoardCells.area());
}

Eigen::Isometry3d drivenTo(int k) {
  Eigen::Isometry3d T_odom_cam = Eigen::Isometry3d::Identity();
  T_odom_cam.translation() = Eigen::Vector3d(0.03 * k, -0.01 * k, 0.1 * k);
  T_odom_cam.linear() = Eigen::AngleAxisd(0.01 * k, Eigen::Vector3d::UnitY()).toRotationMatrix();
  return T_odom_cam;
}

TEST_F(FreeSpaceTest, AStaticSceneIsFixedWhileTheCameraMoves) {
  for (int k = 0; k < 8; ++k) {
    const BoardView view = viewOf(boardScene(), 0.1 * k, drivenTo(k));
    const FreeSpaceEvidence& evidence = compare(view);
    EXPECT_EQ(cv::countNonZero(evidence.moved), 0) << k;
    EXPECT_GT(cv::countNonZero(evidence.fixed), k < 3 ? -1 : 0.9 * 60 * 80) << k;
    remember(view);
  }
}

TEST_F(FreeSpaceTest, ABoardThatAppearsHasMovedWhileTheCameraMoves) {
  for (int k = 0; k < 7; ++k) remember(viewOf(emptyScene(), 0.1 * k, drivenTo(k)));
  const BoardView view = viewOf(boardScene(), 0.7, drivenTo(7));
  const cv::Mat1b moved = compare(view).moved;
  const cv::Mat1b board = cells_.disparity_px > 15;
  EXPECT_GT(cv::countNonZero(board), 400);
  EXPECT_EQ(cv::countNonZero(moved != board), 0);
}

TEST_F(FreeSpaceTest, NeedsTwoFramesThatLookedThrough) {
  for (int count = 0; count < 3; ++count) {
    space_.reset();
    rememberStatic(viewOf(emptyScene(), 0), count);
    expectNothing(compare(viewOf(boardScene(), 0)));
  }
  space_.reset();
  rememberStatic(viewOf(emptyScene(), 0), 3);
  EXPECT_EQ(cv::countNonZero(compare(viewOf(boardScene(), 0)).moved), kBoardCells.area());
}

TEST_F(FreeSpaceTest, ForgetsOnReset) {
  rememberStatic(viewOf(emptyScene(), 0));
  compare(viewOf(boardScene(), 0));
  space_.reset();
  expectNothing(compare(viewOf(boardScene(), 0)));
}

TEST_F(FreeSpaceTest, ThePastFollowsTheColumnCorrection) {
  BoardView past = viewOf(emptyScene(), 0);
  past.input.measured_disparity_px -= 3;
  past.input.measured_disparity_px(cv::Rect(0, 0, 80, 240)) = -1;
  rememberStatic(past);
  const BoardView now = viewOf(emptyScene(), 0);
  EXPECT_EQ(cv::countNonZero(compare(now).fixed), 0) << "the test needs a step that matters";
  space_.addToDisparities(3);
  EXPECT_EQ(cv::countNonZero(compare(now).moved), 0);
  const cv::Mat1b known = cellsIn({19, 0, 61, 60});
  EXPECT_EQ(cv::countNonZero(space_.evidence().fixed != known), 0) << "unknown ones remain so";
  space_.addToDisparities(-20);  // beyond infinity
  expectNothing(compare(now));
}

TEST_F(FreeSpaceTest, ALongGapEndsThePast) {
  const BoardView before = viewOf(emptyScene(), 0);
  rememberStatic(before);  // until -0.1 s
  EXPECT_EQ(cv::countNonZero(compare(viewOf(boardScene(), 0.85)).moved), kBoardCells.area());
  for (const double stamp_s : {0.95, -0.1, -0.25}) {  // a gap, the same frame again, a step back
    SCOPED_TRACE(stamp_s);
    space_.reset();
    rememberStatic(before);
    expectNothing(compare(viewOf(boardScene(), stamp_s)));
    remember(viewOf(boardScene(), stamp_s));
    expectNothing(compare(viewOf(boardScene(), stamp_s + 0.1)));
  }
}

// With the variance of an unseen motion everything would seem to be where it was.
TEST_F(FreeSpaceTest, AMotionThatNobodySawEndsThePast) {
  rememberStatic(viewOf(emptyScene(), 0));
  BoardView after = viewOf(boardScene(), 0.3);
  after.input.motion_covariance = unseenCovariance();
  expectNothing(compare(after));
  remember(after);
  expectNothing(compare(viewOf(boardScene(), 0.4)));
}

// At 60 Hz each fifth frame is remembered: 0, 5, 10.
TEST_F(FreeSpaceTest, RemembersFramesThatAre80msApart) {
  for (int k = 0; k < 11; ++k) {
    SCOPED_TRACE(k);
    expectNothing(compare(viewOf(boardScene(), k / 60.0)));
    remember(viewOf(emptyScene(), k / 60.0));
  }
  EXPECT_EQ(cv::countNonZero(compare(viewOf(boardScene(), 11 / 60.0)).moved), kBoardCells.area());
}

// What comes back to a place, as a flag does, has not moved there.
TEST_F(FreeSpaceTest, WhatWasThereBeforeTheViewThroughComesBack) {
  for (int k = 0; k < 14; ++k) remember(viewOf(k < 9 ? boardScene() : emptyScene(), 0.1 * k));
  // Lags 2, 3, 5 looked through, 8 and 13 saw the board.
  EXPECT_EQ(cv::countNonZero(compare(viewOf(boardScene(), 1.4)).moved), kBoardCells.area());
  space_.reset();
  for (int k = 0; k < 14; ++k) remember(viewOf(k < 10 ? boardScene() : emptyScene(), 0.1 * k));
  // Lags 2, 3 looked through, 5, 8 and 13 saw it.
  EXPECT_EQ(cv::countNonZero(compare(viewOf(boardScene(), 1.4)).moved), 0);
  EXPECT_EQ(cv::countNonZero(space_.evidence().fixed(kBoardCells)), kBoardCells.area());
}

constexpr int kFrames = 3, kRow_px = 22;

enum class Sight { kNone, kThrough, kSame };

class FreeSpaceRows : public testing::TestWithParam<int> {
 protected:
  FreeSpaceRows() : random_(static_cast<unsigned>(GetParam())) {
    const auto n = static_cast<size_t>(GetParam());
    for (size_t i = 0; i < n; ++i) {
      disparity.push_back(value(0, 1) < 0.1f ? 0 : value(0, 20));
      variance.push_back(value(0, 0.5));
      width.push_back(value(0, 60));
    }
    for (int k = 0; k < kFrames; ++k) {
      nearest[k] = cv::Mat1f(20, 2 * GetParam() + 8);
      farthest[k] = nearest[k].clone();
      for (int v = 0; v < nearest[k].rows; ++v)
        for (int u = 0; u < nearest[k].cols; ++u) {
          farthest[k](v, u) = value(0, 1) < 0.1f ? 0 : value(2, 18);
          nearest[k](v, u) = farthest[k](v, u) > 0 ? farthest[k](v, u) + value(0, 3) : 0;
        }
      // Moves by columns, by a row and in depth.
      H[k] = {1, 0, 0, 0, 0, 1, 0, 0, 0.1f, 0, 1, 0.001f, value(-9, 9), 3, 0.2f, 1};
      past.push_back({{H[k].data(), int(nearest[k].step1()), nearest[k].cols, nearest[k].rows},
                      nearest[k][0],
                      farthest[k][0],
                      {0.01f, {0.001f, 0.002f}, {0.0001f, 0.0002f, 0.0003f}}});
    }
  }
  float value(double low, double high) {
    return static_cast<float>(std::uniform_real_distribution<double>(low, high)(random_));
  }
  SightRow row() const {
    return {disparity.data(), variance.data(), width.data(), GetParam(), kRow_px, 40, 300, 60};
  }

  Sight sightOf(int u, int k) const {
    const std::array<float, 16>& h = H[static_cast<size_t>(k)];
    const auto i = static_cast<size_t>(u);
    const float x = static_cast<float>(2 + 4 * u), y = kRow_px, d = disparity[i];
    const float w = h[3] * x + h[7] * y + h[11] * d + h[15];
    const float per_w = 1 / w;
    const float column = (h[0] * x + h[4] * y + h[8] * d + h[12]) * per_w * 0.5f + 0.5f,
                line = (h[1] * x + h[5] * y + h[9] * d + h[13]) * per_w * 0.5f + 0.5f,
                expected = (h[2] * x + h[6] * y + h[10] * d + h[14]) * per_w;
    const cv::Mat1f &near = nearest[k], &far = farthest[k];
    if (!(expected > 0 && column >= 0 && line >= 0 && column < static_cast<float>(near.cols) &&
          line < static_cast<float>(near.rows)))
      return Sight::kNone;
    const cv::Point p(static_cast<int>(column), static_cast<int>(line));
    if (!(near(p) > 0)) return Sight::kNone;
    if (far(p) <= expected && expected <= near(p)) return Sight::kSame;
    const float by_depth = expected * expected * (1 / 60.0f);
    const float of_depth =
        past[static_cast<size_t>(k)].noise.variance((x - 40) * (1 / 300.0f), 60 / d);
    const float scale2 = kScaleSigma * kScaleSigma;
    const float threshold2 = 4 * (variance[i] + kDisparitySigma_px * kDisparitySigma_px +
                                  by_depth * by_depth * of_depth + scale2 * expected * expected);
    const float behind = expected - near(p), before = far(p) - expected;
    if (behind > 0 && behind * behind > threshold2)
      return width[i] * expected < kThinnest_px * d ? Sight::kNone : Sight::kThrough;
    return before < 0 || before * before < threshold2 ? Sight::kSame : Sight::kNone;
  }

  std::vector<float> disparity, variance, width;
  std::array<cv::Mat1f, kFrames> nearest, farthest;
  std::array<std::array<float, 16>, kFrames> H;
  std::vector<PastSight> past;

 private:
  std::mt19937 random_;
};

TEST_P(FreeSpaceRows, CountSights) {
  std::vector<uint8_t> through_by(disparity.size()), fixed(disparity.size());
  int moved = 0;
  forEveryTarget([&] {
    sightsRow(row(), past.data(), kFrames, through_by.data(), fixed.data());
    for (int u = 0; u < GetParam(); ++u) {
      SCOPED_TRACE(testing::Message() << u);
      int through = 0, same = 0, came_back = 0, first = 0;
      for (int k = 0; k < kFrames && disparity[size_t(u)] > 0; ++k) {
        const Sight sight = sightOf(u, k);
        if (sight == Sight::kThrough && ++through == 1) first = k + 1;
        if (sight != Sight::kSame) continue;
        ++same;
        came_back += through > 0;
      }
      EXPECT_EQ(fixed[size_t(u)], same > 0 ? 255 : 0);
      EXPECT_EQ(through_by[size_t(u)], through >= 2 && through > came_back ? first : 0);
      moved += through_by[size_t(u)] != 0;
    }
  });
  if (GetParam() >= 64) {
    EXPECT_GT(moved, 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Widths, FreeSpaceRows, testing::Values(1, 3, 16, 63, 64, 65, 200));

}  // namespace
}  // namespace predictive_stereo
