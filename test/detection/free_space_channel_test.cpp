/// Boards on a level ground before a wall, with exact disparities.
#include "detection/free_space_channel.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <vector>

#include "cell_rig.h"
#include "detection/board_scene.h"
#include "detection/constants.h"
#include "frame_parts.h"

namespace predictive_stereo {
namespace {

constexpr double kCameraHeight_m = 1.5;

// On the ground, unless its foot is higher.
Board standing(double left_m, double width_m, double height_m, double depth_m, double foot_m = 0) {
  return {left_m, kCameraHeight_m - foot_m - height_m, width_m, height_m, depth_m};
}

// Somebody who runs to the right by 0.4 m = 6 cells from frame to frame.
Board runner(int k) { return standing(-2 + 0.4 * k, 0.6, 1.7, 5); }

BoardScene sceneWith(const std::vector<Board>& boards, double wall_m = 20) {
  BoardScene scene{{wallAt(wall_m)}, kCameraHeight_m};
  scene.boards.insert(scene.boards.end(), boards.begin(), boards.end());
  return scene;
}

class FreeSpaceChannelTest : public testing::Test {
 protected:
  std::vector<Observation> find(
      const BoardScene& scene, int k,
      const Eigen::Isometry3d& T_odom_cam = Eigen::Isometry3d::Identity()) {
    return find(viewOf(scene, 0.1 * k, T_odom_cam));
  }
  std::vector<Observation> find(const BoardView& view,
                                const DisparityRange& range = DisparityRange()) {
    parts_.input = view.input;
    parts_.range = range;
    parts_.current.pyramid.build(view.input.left, 2);
    parts_.cells.setFrame(range, view.input.measured_disparity_px,
                          view.input.measured_variance_px2);
    ground_.setFrame(view.input.rig, parts_.cells);
    parts_.ground = ground_.plane();
    parts_.obstacles = findObstacles(view.input.rig, parts_.cells, parts_.ground);
    return channel_.find(parts_.frame, parts_.cells);
  }
  void reset() {
    channel_.reset();
    ground_.reset();
  }
  // What is found where some boards have come to a scene that was seen for 0.6 s.
  std::vector<Observation> findAfter(
      const BoardScene& before, const std::vector<Board>& come,
      const Eigen::Isometry3d& T_odom_cam = Eigen::Isometry3d::Identity()) {
    reset();
    for (int k = 0; k < 6; ++k) EXPECT_TRUE(find(before, k, T_odom_cam).empty()) << k;
    BoardScene after = before;
    after.boards.insert(after.boards.end(), come.begin(), come.end());
    return find(after, 6, T_odom_cam);
  }
  FreeSpaceChannel channel_;
  SteadyGround ground_;
  FrameParts parts_;
  MotionDetectionParams& params_ = parts_.params;
};

// Pixels of a board, without the lowest 0.25 m if it stands on the ground.
cv::Rect2d boxOf(const Board& board) {
  const double px_per_m = 300 / board.depth_m;
  const double foot_m = board.top_m + board.height_m;
  const double lowest_m = std::min(foot_m, kCameraHeight_m - kGap_m);
  return {160 + board.left_m * px_per_m, 120 + board.top_m * px_per_m, board.width_m * px_per_m,
          (lowest_m - board.top_m) * px_per_m};
}

void expectEdges(const cv::Rect& box, const cv::Rect2d& expected) {
  EXPECT_NEAR(box.x, expected.x, kCellSide_px);
  EXPECT_NEAR(box.y, expected.y, kCellSide_px);
  EXPECT_NEAR(box.br().x, expected.br().x, kCellSide_px);
  EXPECT_NEAR(box.br().y, expected.br().y, kCellSide_px);
}

void expectBox(const Observation& object, const cv::Rect2d& expected) {
  const cv::Rect& box = object.box_px;
  expectEdges(box, expected);
  EXPECT_EQ(object.mask.size(), box.size());
  const cv::Rect inner = cv::boundingRect(object.mask);
  EXPECT_EQ(cv::countNonZero(object.mask), inner.area()) << "a rectangle";
  EXPECT_GT(inner.width, box.width - kCellSide_px);
  EXPECT_GT(inner.height, box.height - kCellSide_px);
}

TEST_F(FreeSpaceChannelTest, FindsAnObjectWhole) {
  const Board stays = standing(3, 0.6, 1.7, 7);
  for (int k = 0; k < 9; ++k) {
    SCOPED_TRACE(k);
    const auto objects = find(sceneWith({stays, runner(k)}), k);
    ASSERT_EQ(objects.size(), k < 3 ? 0u : 1u);
    if (objects.empty()) continue;
    expectBox(objects[0], boxOf(runner(k)));
    const Observation& seen = objects[0];
    EXPECT_NEAR(seen.distance_m, 5, 1e-3);
    EXPECT_NEAR(seen.centre_m.x(), runner(k).left_m + 0.3, 0.05);
    EXPECT_NEAR(seen.centre_m.z(), 5, 1e-3);
    EXPECT_GT(seen.score, 0.9);
  }
}

TEST_F(FreeSpaceChannelTest, TheBackgroundBesideANarrowObjectIsNoPartOfIt) {
  const auto objects = findAfter(sceneWith({}), {standing(-1.03, 0.6, 1.7, 5)});
  ASSERT_EQ(objects.size(), 1u);
  EXPECT_NEAR(objects[0].centre_m.z(), 5, 1e-3);
  EXPECT_NEAR(objects[0].centre_m.x(), -0.73, 0.05);
}

TEST_F(FreeSpaceChannelTest, FindsItWhileTheCameraDrives) {
  for (int k = 0; k < 7; ++k) {
    SCOPED_TRACE(k);
    Eigen::Isometry3d T_odom_cam = Eigen::Isometry3d::Identity();
    T_odom_cam.translation().z() = 0.2 * k;
    Board ahead = runner(k);
    ahead.depth_m += 2;
    const auto objects = find(sceneWith({standing(1.5, 0.6, 1.7, 7), ahead}), k, T_odom_cam);
    ASSERT_EQ(objects.size(), k < 3 ? 0u : 1u);
    if (objects.empty()) continue;
    ahead.depth_m -= 0.2 * k;
    expectBox(objects[0], boxOf(ahead));
  }
}

// An object comes 2 m before a wall.
TEST_F(FreeSpaceChannelTest, AsksForMoreWhereTheMotionIsLessCertain) {
  const auto found = [&](double variance) {
    reset();
    size_t objects = 0;
    for (int k = 0; k < 7; ++k) {
      std::vector<Board> boards;
      if (k == 6) boards.push_back(standing(-0.5, 0.8, 1.7, 5));
      BoardView view = viewOf(sceneWith(boards, 7), 0.1 * k);
      view.input.motion_covariance = variance * Matrix6d::Identity();
      objects = find(view).size();
    }
    return objects;
  };
  EXPECT_EQ(found(1e-6), 1u);
  EXPECT_EQ(found(1), 0u);
  EXPECT_EQ(found(kUnseenVariance), 0u);
  EXPECT_EQ(found(0), 1u) << "not told";
}

// Unknown disparities are 8 here, and the farthest ones of the object 9.1.
TEST_F(FreeSpaceChannelTest, UnknownPixelsAreNoPartOfAnObject) {
  const DisparityRange range{9, 64};
  const BoardScene wall = {{wallAt(9.9)}};
  for (int k = 0; k < 6; ++k) {
    EXPECT_TRUE(find(viewOf(wall, 0.1 * k), range).empty());
  }
  BoardView view = viewOf({{wallAt(9.9), {-1.2, -0.8, 2.4, 1.6, 8}}}, 0.6);
  cv::Mat1f& disparity_px = view.input.measured_disparity_px;
  disparity_px.colRange(0, 240).setTo(range.invalid());
  for (int x = 116; x < 204; ++x)
    if (x % 4 != 1) disparity_px(cv::Rect(x, 92, 1, 56)) = 9.1f + 0.04f * float(x - 116);
  const auto objects = find(view, range);
  ASSERT_EQ(objects.size(), 1u);
  const cv::Mat1b known = disparity_px(objects[0].box_px) != range.invalid();
  EXPECT_EQ(cv::countNonZero(objects[0].mask & ~known), 0);
  EXPECT_GT(cv::countNonZero(objects[0].mask), 0.9 * cv::countNonZero(known));
}

TEST_F(FreeSpaceChannelTest, LeavesOutWhatHasGrownTogetherWithAStaticWall) {
  const Board come = standing(-0.6, 0.6, 1.7, 5);
  EXPECT_TRUE(findAfter(sceneWith({standing(0, 2.6, 1.7, 5.1)}), {come}).empty());
  const auto apart = findAfter(sceneWith({standing(0, 2, 1.7, 7)}), {come});
  ASSERT_EQ(apart.size(), 1u);
  expectBox(apart[0], boxOf(come));
}

// A walker of whom the past shows that it looked through his head alone: below, nothing is known
// but himself.
TEST_F(FreeSpaceChannelTest, FindsAWalkerWholeOfWhomMostIsWhereItWas) {
  constexpr int kUnknownFrom_px = 140;
  const auto walker = [](int k) { return standing(-1 + 0.1 * k, 0.6, 1.7, 5); };
  std::vector<Observation> objects;
  for (int k = 0; k < 12; ++k) {
    BoardScene scene = sceneWith({walker(k)});
    scene.ground_m = 2;  // its disparity is nowhere that of the walker
    BoardView view = viewOf(scene, 0.1 * k);
    cv::Mat1f below = view.input.measured_disparity_px.rowRange(kUnknownFrom_px, 240);
    below.setTo(DisparityRange().invalid(), below != 18);
    objects = find(view);
  }
  ASSERT_EQ(objects.size(), 1u);
  expectEdges(objects[0].box_px, {166, 108, 36, 102});
  EXPECT_LT(objects[0].score, 0.5) << "the test needs a walker who seems to stand";
}

// Another plane in each frame, of what noise and walls look like.
TEST_F(FreeSpaceChannelTest, AGroundThatTheNextFrameDoesNotShowIsNone) {
  const auto frame = [&](int k, double ground_m, bool come) {
    BoardScene scene = sceneWith({}, 10);
    scene.ground_m = ground_m;
    if (come) scene.boards.push_back({-0.5, -1.5, 0.8, 1, 5});
    return find(viewOf(scene, 0.1 * k));
  };
  for (const bool same : {true, false}) {
    reset();
    for (int k = 0; k < 6; ++k) frame(k, 1.5, false);
    // It flies above the ground, if there is one.
    EXPECT_EQ(frame(6, same ? 1.5 : 1.9, true).size(), same ? 0u : 1u);
  }
}

TEST_F(FreeSpaceChannelTest, LeavesOutWhatFlies) {
  const BoardScene empty = sceneWith({});
  // Up to max_foot_m = 1.2.
  const Board low = standing(-0.5, 1, 1.2, 5, 1.1), high = standing(-0.5, 1, 1.2, 5, 1.6);
  EXPECT_EQ(findAfter(empty, {low}).size(), 1u);
  EXPECT_TRUE(findAfter(empty, {high}).empty());
  params_.max_foot_m = 1.7;
  const auto objects = findAfter(empty, {high});
  ASSERT_EQ(objects.size(), 1u);
  expectBox(objects[0], boxOf(high));
}

// A static fence hides its lowest 0.75 m.
TEST_F(FreeSpaceChannelTest, FindsWhatSomethingNearerHidesBelow) {
  params_.max_foot_m = 0.3;
  const BoardScene fence = sceneWith({standing(-0.8, 1.6, 1, 4)});
  EXPECT_EQ(findAfter(fence, {standing(-0.5, 1, 2.4, 6)}).size(), 1u);
  EXPECT_TRUE(findAfter(sceneWith({}), {standing(-0.5, 1, 1.65, 6, 0.75)}).empty());
}

TEST_F(FreeSpaceChannelTest, LeavesOutImplausibleSizes) {
  const BoardScene empty = sceneWith({});
  const Board object = standing(-0.5, 1, 1.5, 5);
  ASSERT_EQ(findAfter(empty, {object}).size(), 1u);
  const auto isFoundWith = [&](double MotionDetectionParams::*limit, double value) {
    params_ = MotionDetectionParams();
    params_.*limit = value;
    return !findAfter(empty, {object}).empty();
  };
  EXPECT_TRUE(isFoundWith(&MotionDetectionParams::min_width_m, 0.9));
  EXPECT_FALSE(isFoundWith(&MotionDetectionParams::min_width_m, 1.1));
  EXPECT_TRUE(isFoundWith(&MotionDetectionParams::max_width_m, 1.1));
  EXPECT_FALSE(isFoundWith(&MotionDetectionParams::max_width_m, 0.9));
  EXPECT_TRUE(isFoundWith(&MotionDetectionParams::min_height_m, 1.4));
  EXPECT_FALSE(isFoundWith(&MotionDetectionParams::min_height_m, 1.6));
  EXPECT_TRUE(isFoundWith(&MotionDetectionParams::max_height_m, 1.6));
  EXPECT_FALSE(isFoundWith(&MotionDetectionParams::max_height_m, 1.4));
}

TEST_F(FreeSpaceChannelTest, APoseThatJumpsEndsThePast) {
  const std::vector<Board> still = {standing(-1.8, 0.6, 1.7, 5), standing(1.2, 0.8, 1.7, 6)};
  Eigen::Isometry3d T_jumped = Eigen::Isometry3d::Identity();
  T_jumped.translation() = Eigen::Vector3d(0.7, 0.5, -2.5);
  const auto jumpedView = [&](const BoardScene& scene, int k) {
    BoardView view = viewOf(scene, 0.1 * k);
    view.input.T_odom_cam = T_jumped;
    return view;
  };
  for (int k = 0; k < 8; ++k) EXPECT_TRUE(find(sceneWith(still, 8), k).empty()) << k;
  EXPECT_TRUE(find(jumpedView(sceneWith(still, 8), 8)).empty());
  // Now three frames are remembered first.
  for (int k = 9; k < 12; ++k) EXPECT_TRUE(find(jumpedView(sceneWith(still, 8), k)).empty()) << k;
  std::vector<Board> boards = still;
  boards.push_back(standing(-0.6, 0.6, 1.7, 5));
  const auto objects = find(jumpedView(sceneWith(boards, 8), 12));
  ASSERT_EQ(objects.size(), 1u);
  expectBox(objects[0], boxOf(boards[2]));
}

// It sees 1.1 m of height as 0.55 m: the height above the ground counts.
TEST_F(FreeSpaceChannelTest, FindsAPersonFromAbove) {
  Eigen::Isometry3d T_odom_cam = Eigen::Isometry3d::Identity();
  T_odom_cam.linear() =
      Eigen::AngleAxisd(-50 * M_PI / 180, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const double down_m = 2.7;
  const BoardScene floor{{wallAt(20)}, down_m};
  ASSERT_EQ(params_.min_height_m, 0.8);
  const auto objects = findAfter(floor, {{-0.3, down_m - 1.1, 0.6, 1.1, 2.5}}, T_odom_cam);
  ASSERT_EQ(objects.size(), 1u);
  EXPECT_LT(objects[0].box_px.br().y, 236) << "not cut by the image";
  EXPECT_LT(objects[0].box_px.height * objects[0].distance_m / 300, 0.75);
  EXPECT_TRUE(findAfter(floor, {{-0.3, down_m - 0.7, 0.6, 0.7, 2.5}}, T_odom_cam).empty());
}

TEST_F(FreeSpaceChannelTest, ForgetsOnResetAndFollowsTheColumnCorrection) {
  const std::vector<Board> come = {standing(-0.6, 0.6, 1.7, 5)};
  for (int k = 0; k < 6; ++k) find(sceneWith({}), k);
  reset();
  EXPECT_TRUE(find(sceneWith(come), 6).empty());

  reset();
  for (int k = 0; k < 6; ++k) {
    BoardView shifted = viewOf(sceneWith({}), 0.1 * k);
    shifted.input.measured_disparity_px += 2.5f;
    find(shifted);
  }
  channel_.addToDisparities(-2.5);
  EXPECT_EQ(find(sceneWith(come), 6).size(), 1u);
}

TEST_F(FreeSpaceChannelTest, IsTheSameOnAnyNumberOfThreads) {
  const int threads_before = cv::getNumThreads();
  std::vector<std::vector<Observation>> found;
  for (const int threads : {1, 2, 3}) {
    cv::setNumThreads(threads);
    reset();
    found.emplace_back();
    for (int k = 0; k < 7; ++k) {
      BoardView view = viewOf(sceneWith({standing(3, 0.6, 1.7, 7), runner(k)}), 0.1 * k);
      cv::RNG random(20 + k);
      for (float& d : view.input.measured_disparity_px) d += float(random.gaussian(0.1));
      for (Observation& object : find(view)) found.back().push_back(std::move(object));
    }
  }
  cv::setNumThreads(threads_before);
  ASSERT_GE(found[0].size(), 4u);
  for (size_t i = 1; i < found.size(); ++i) {
    ASSERT_EQ(found[i].size(), found[0].size());
    for (size_t k = 0; k < found[0].size(); ++k) {
      const Observation &one = found[0][k], &other = found[i][k];
      EXPECT_EQ(other.box_px, one.box_px);
      EXPECT_EQ(other.centre_m, one.centre_m);
      EXPECT_EQ(other.size_m, one.size_m);
      EXPECT_EQ(other.distance_m, one.distance_m);
      EXPECT_EQ(other.score, one.score);
      EXPECT_EQ(cv::countNonZero(other.mask != one.mask), 0);
    }
  }
}

// An object of all pixels of these cells.
Observation objectAt(const cv::Rect& cells) {
  Observation object;
  object.box_px = {kCellSide_px * cells.tl(), cells.size() * kCellSide_px};
  object.mask = cv::Mat1b(object.box_px.size(), 255);
  return object;
}

TEST(JoinedObjects, HaveBothWithoutThinEnds) {
  Observation part = objectAt({10, 10, 4, 4}), whole = objectAt({8, 8, 40, 40});
  part.score = 0.7;
  whole.mask.setTo(0);
  whole.mask(cv::Rect(12, 12, 80, 80)).setTo(255);  // from 44, 44 on
  whole.mask(cv::Rect(92, 40, 60, 20)).setTo(255);  // a quarter of the height
  whole.mask(cv::Rect(20, 92, 45, 10)).setTo(255);  // a third of the fullest row
  const Observation both = joined(part, whole);
  EXPECT_EQ(both.score, 0.7);
  EXPECT_EQ(cv::Rect(both.box_px), cv::Rect(40, 40, 84, 94));
  ASSERT_EQ(both.mask.size(), cv::Size(84, 94));
  EXPECT_EQ(cv::countNonZero(both.mask), 80 * 80 + 45 * 10 + 16 * 16 - 12 * 12);
}

TEST(JoinedObjects, OneOfWhichIsNothingAreThePart) {
  const Observation part = objectAt({10, 10, 4, 4});
  Observation nothing = objectAt({30, 30, 4, 4});
  nothing.mask.setTo(0);
  const Observation both = joined(part, nothing);
  EXPECT_EQ(both.box_px, part.box_px);
  EXPECT_EQ(cv::countNonZero(both.mask != part.mask), 0);
}

TEST(ObjectOfAnObstacle, HasNoPixelsOfAnotherSurface) {
  const cv::Rect body(20, 5, 6, 12), legs(18, 17, 10, 12), person = body | legs;  // cells
  FrameParts parts;
  cv::Mat1f& disparity_px = parts.input.measured_disparity_px;
  disparity_px = cv::Mat1f(cellRig().size, 20.0f);
  disparity_px(cv::Rect(80, 20, 3, 48)) = 5;
  parts.cells = unknownCells(0.04f);
  for (const cv::Rect& part : {body, legs}) parts.cells.disparity_px(part) = 20;
  const Obstacles obstacles = findObstacles(cellRig(), parts.cells, std::nullopt);
  const Observation object = objectOf(parts.frame, obstacles.cellsOf(0));
  EXPECT_EQ(cv::Rect(object.box_px),
            cv::Rect(kCellSide_px * person.tl(), person.size() * kCellSide_px));
  EXPECT_EQ(cv::countNonZero(object.mask), 16 * (body.area() + legs.area()) - 3 * 48);
}

}  // namespace
}  // namespace predictive_stereo
