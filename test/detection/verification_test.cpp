/// Objects that were verified become the objects of a frame. The ends of a car, 10 m away, come one
/// after the other; 40 columns are between them.
#include "detection/verification.h"

#include <gtest/gtest.h>

#include "frame_parts.h"

namespace predictive_stereo {
namespace {

struct FoundObjects : FrameParts, testing::Test {
  FoundObjects() {
    input.rig.size = {400, 200};
    input.rig.fx_px = input.rig.fy_px = 500;
    input.rig.cx_left_px = input.rig.cx_right_px = 200;
    input.rig.cy_px = 100;
    input.rig.baseline_m = 0.5;
    input.measured_disparity_px = cv::Mat1f(input.rig.size, car_px());
    current.pyramid.build(cv::Mat1b(input.rig.size, 128), 2);
    verification.setFrame(frame, cv::Mat1f());
  }
  float car_px() const { return static_cast<float>(input.rig.disparityTimesDepth() / 10); }
  VerifiedObject moving(const cv::Rect& box, double speed_mps) const {
    VerifiedObject found;
    found.object.mask = cv::Mat1b(box.size(), 255);
    Observation& seen = found.object;
    seen.box_px = box;
    EXPECT_TRUE(measureShape(input, range, found.object));
    seen.has_velocity = true;
    seen.velocity_mps.x() = speed_mps;
    found.segment.area = cv::Rect(box.x / 2, box.y / 2, box.width / 2, box.height / 2);
    found.segment.mask = cv::Mat1b(found.segment.area.size(), 255);
    found.hypothesis.seeds = {found.segment.area.tl()};
    return found;
  }
  std::vector<cv::Rect> boxesOf(const std::vector<VerifiedObject>& found) {
    verification.addAll(frame, found,
                        [](const VerifiedObject& object) { return std::optional(object); });
    std::vector<cv::Rect> boxes;
    for (const Observation& object : verification.objects()) {
      boxes.push_back(object.box_px);
      EXPECT_EQ(object.mask.size(), object.box_px.size());
    }
    return boxes;
  }

  Verification verification;
};

const cv::Rect kRear(100, 80, 40, 60), kDoor(140, 80, 40, 60), kFront(180, 80, 40, 60);

TEST_F(FoundObjects, AreOneIfTheyMoveAsOne) {
  const auto boxes = boxesOf({moving(kRear, 5), moving(kFront, 5.2)});
  ASSERT_EQ(boxes.size(), 1u);
  EXPECT_EQ(boxes[0], kRear | kFront);
  EXPECT_NEAR(verification.objects()[0].size_m.x(), 120 * 10 / 500., 0.3);
  EXPECT_TRUE(verification.isTaken(kFront.tl() / 2)) << "not found again";
  EXPECT_FALSE(verification.isTaken(kDoor.tl() / 2));
}

TEST_F(FoundObjects, AreOneIfTheyOverlap) {
  const cv::Rect most = kRear | kDoor, last(130, 80, 90, 60);
  ASSERT_GT(2 * (most & last).area(), most.area()) << "too much for two objects";
  VerifiedObject rest = moving(last, 5.2);
  rest.hypothesis.seeds = {kFront.tl() / 2};
  EXPECT_EQ(boxesOf({moving(most, 5), rest}), std::vector<cv::Rect>{kRear | kFront});
}

TEST_F(FoundObjects, AreTwoOfTwoVelocities) {
  EXPECT_EQ(boxesOf({moving(kRear, 5), moving(kFront, 1)}), (std::vector<cv::Rect>{kRear, kFront}));
}

TEST_F(FoundObjects, AreTwoIfTheBackgroundIsBetweenThem) {
  input.measured_disparity_px(kDoor).setTo(car_px() / 3);
  EXPECT_EQ(boxesOf({moving(kRear, 5), moving(kFront, 5)}), (std::vector<cv::Rect>{kRear, kFront}));
}

TEST_F(FoundObjects, AreNotWiderThanAnObject) {
  params.max_width_m = 2;
  EXPECT_EQ(boxesOf({moving(kRear, 5), moving(kFront, 5)}), (std::vector<cv::Rect>{kRear, kFront}));
}

// In whatever order the ends of a lorry and its side, which is farther away, are found.
TEST_F(FoundObjects, HaveNoPartsOfTheirOwn) {
  const cv::Rect side(140, 80, 16, 24);
  input.measured_disparity_px(side).setTo(car_px() / 1.2f);
  const VerifiedObject rear = moving(kRear, 5), part = moving(side, 5), front = moving(kFront, 5);
  const auto foundIn = [&](const std::vector<VerifiedObject>& order) {
    verification.setFrame(frame, cv::Mat1f());
    verification.forgetObjects();
    return boxesOf(order);
  };
  const std::vector<cv::Rect> rear_only{kRear}, whole{kRear | kFront};
  EXPECT_EQ(foundIn({rear, part}), rear_only);
  EXPECT_EQ(foundIn({part, rear}), rear_only);
  EXPECT_TRUE(verification.isTaken(side.tl() / 2)) << "not found again";
  EXPECT_EQ(foundIn({rear, front, part}), whole);
  EXPECT_EQ(foundIn({rear, part, front}), whole);
  EXPECT_EQ(foundIn({part, rear, front}), whole);
  EXPECT_EQ(foundIn({part, front, rear}), whole);
}

TEST_F(FoundObjects, AreFoundOnce) {
  EXPECT_EQ(boxesOf({moving(kRear, 5), moving(kRear, 1)}).size(), 1u) << "the first one wins";
}

}  // namespace
}  // namespace predictive_stereo
