/// Boards on small maps of cells.
#include "detection/whole_object.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "cell_rig.h"

namespace predictive_stereo {
namespace {

const cv::Rect kBody(20, 5, 6, 12), kLegs(18, 17, 10, 12), kPerson = kBody | kLegs;

// A person of whom the body has moved, and whose legs stand.
class WholeObjectTest : public testing::Test {
 protected:
  WholeObjectTest() {
    evidence_.moved = cv::Mat1b::zeros(kCellRows, kCellColumns);
    for (const cv::Rect& part : {kBody, kLegs}) cells_.disparity_px(part) = 20;
    evidence_.moved(kBody) = 255;
  }
  std::vector<cv::Point> whole(const cv::Rect& part_cells = kBody) const {
    const Obstacles obstacles = findObstacles(cellRig(), cells_, std::nullopt);
    const Obstacles::Cells whole = wholeObstacle(objectAt(part_cells), obstacles, evidence_);
    return {whole.begin(), whole.end()};
  }
  static ObservedObject objectAt(const cv::Rect& part) {
    ObservedObject object;
    object.observation.box_px = {kCellSide_px * part.tl(), part.size() * kCellSide_px};
    object.mask = cv::Mat1b(object.observation.box_px.size(), 255);
    return object;
  }
  static cv::Rect areaOf(const std::vector<cv::Point>& cells) { return cv::boundingRect(cells); }

  DepthCells cells_ = unknownCells(0.04f);
  FreeSpaceEvidence evidence_;
};

TEST_F(WholeObjectTest, TheLegsBelongToTheBody) {
  const auto cells = whole();
  EXPECT_EQ(areaOf(cells), kPerson);
  EXPECT_EQ(cells.size(), size_t(kBody.area() + kLegs.area()));
}

TEST_F(WholeObjectTest, NotWhatIsBehindOrApart) {
  cells_.disparity_px(cv::Rect(26, 5, 20, 12)) = 8;
  cells_.disparity_px(cv::Rect(32, 20, 6, 8)) = 20;
  EXPECT_EQ(areaOf(whole()), kPerson);
}

TEST_F(WholeObjectTest, NotWithoutFreeSpaceThatItViolates) {
  evidence_.moved.setTo(0);
  EXPECT_TRUE(whole().empty());
}

TEST_F(WholeObjectTest, NotFromASmallPart) {
  EXPECT_FALSE(whole(cv::Rect(20, 5, 6, 7)).empty());  // 42 of 192
  EXPECT_TRUE(whole(cv::Rect(20, 5, 6, 6)).empty());
}

TEST_F(WholeObjectTest, NotFromAPartOnSeveralObstacles) {
  cells_.disparity_px(cv::Rect(26, 5, 20, 24)) = 8;
  EXPECT_FALSE(whole(cv::Rect(20, 5, 12, 12)).empty());
  EXPECT_TRUE(whole(cv::Rect(18, 3, 13, 14)).empty()) << "most of it is on none";
}

TEST_F(WholeObjectTest, JoinedHasBothWithoutThinEnds) {
  ObservedObject part = objectAt({10, 10, 4, 4}), whole = objectAt({8, 8, 40, 40});
  part.observation.score = 0.7;
  whole.mask.setTo(0);
  whole.mask(cv::Rect(12, 12, 80, 80)).setTo(255);  // from 44, 44 on
  whole.mask(cv::Rect(92, 40, 60, 20)).setTo(255);  // a quarter of the height
  whole.mask(cv::Rect(20, 92, 45, 10)).setTo(255);  // a third of the fullest row
  const ObservedObject both = joined(part, whole);
  EXPECT_EQ(both.observation.score, 0.7);
  EXPECT_EQ(cv::Rect(both.observation.box_px), cv::Rect(40, 40, 84, 94));
  ASSERT_EQ(both.mask.size(), cv::Size(84, 94));
  EXPECT_EQ(cv::countNonZero(both.mask), 80 * 80 + 45 * 10 + 16 * 16 - 12 * 12);
}

TEST_F(WholeObjectTest, JoinedWithNothingIsThePart) {
  const ObservedObject part = objectAt({10, 10, 4, 4});
  ObservedObject nothing = objectAt({30, 30, 4, 4});
  nothing.mask.setTo(0);
  const ObservedObject both = joined(part, nothing);
  EXPECT_EQ(both.observation.box_px, part.observation.box_px);
  EXPECT_EQ(cv::countNonZero(both.mask != part.mask), 0);
}

TEST_F(WholeObjectTest, PixelsOfAnotherSurfaceAreNoneOfTheObject) {
  const StereoRig rig = cellRig();
  cv::Mat1f disparity_px(rig.size, 20.0f);
  disparity_px(cv::Rect(80, 20, 3, 48)) = 5;
  const Obstacles obstacles = findObstacles(rig, cells_, std::nullopt);
  const ObservedObject object =
      objectOf(obstacles[0], obstacles[0].area(), cells_, DisparityRange(), disparity_px);
  EXPECT_EQ(cv::Rect(object.observation.box_px),
            cv::Rect(kCellSide_px * kPerson.tl(), kPerson.size() * kCellSide_px));
  EXPECT_EQ(cv::countNonZero(object.mask), 16 * (kBody.area() + kLegs.area()) - 3 * 48);
}

}  // namespace
}  // namespace predictive_stereo
