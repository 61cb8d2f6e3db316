/// Effects of perturbations on images, frames and labels.
#include "evaluation/perturbation.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

namespace predictive_stereo {
namespace {

constexpr int kFrames = 12;

// Frame i shows grey level 10 i + x; a box of 20 px at depth 8 m, which is 10 px of disparity.
class Ramp : public Sequence {
 public:
  Ramp() : Sequence("ramp") {
    rig_.size = {100, 20};
    rig_.fx_px = rig_.fy_px = 160;
    rig_.cx_left_px = 48;
    rig_.cx_right_px = 45;
    rig_.cy_px = 10;
    rig_.baseline_m = 0.5;
  }
  int frames() const override { return kFrames; }
  int fileNumber(int index) const override { return 100 + index; }
  SequenceFrame frame(int index) const override {
    SequenceFrame frame{cv::Mat1b(rig_.size), cv::Mat1b(rig_.size), {}, {}};
    for (int y = 0; y < 20; ++y)
      for (int x = 0; x < 100; ++x) {
        frame.left(y, x) = static_cast<uchar>(10 * index + x);
        frame.right(y, x) = static_cast<uchar>(10 * index + x / 2);
      }
    return frame;
  }

 private:
  std::optional<std::vector<ObjectLabel>> trueObjects(int) const override {
    ObjectLabel label;
    label.track = 1;
    label.type = "car";
    label.box_px = {40, 5, 20, 10};
    label.distance_m = 8;
    return std::vector<ObjectLabel>{label};
  }
};

Perturbation change() { return {}; }

TEST(Perturbation, TheFirstOneChangesNothing) {
  const auto ramp = std::make_shared<const Ramp>();
  const auto same = perturbed(ramp, perturbations()[0]);
  ASSERT_EQ(same->frames(), kFrames);
  EXPECT_EQ(cv::norm(same->frame(3).right, ramp->frame(3).right, cv::NORM_INF), 0);
  EXPECT_EQ(perturbations()[0].applyTo({}).disparity.search.margin_px,
            SearchRangeParams().margin_px);
}

TEST(Perturbation, TheMirroredWorldsLeftCameraIsTheRightOne) {
  const auto ramp = std::make_shared<const Ramp>();
  Perturbation mirror = change();
  mirror.mirrored = true;
  const std::shared_ptr<const Sequence> once = perturbed(ramp, mirror);
  EXPECT_EQ(once->frame(2).left(0, 0), ramp->frame(2).right(0, 99));
  EXPECT_EQ(once->rig().cx_left_px, 99 - 45);
  EXPECT_EQ(once->rig().cx_right_px, 99 - 48);
  // Columns 40 to 59 are 10 + 3 px further left in the right image: 27 to 46; mirrored, 53 to 72.
  const ObjectLabel label = once->objects(2)->at(0);
  EXPECT_EQ(label.box_px, cv::Rect2d(53, 5, 20, 10));
  EXPECT_TRUE(label.isDemanded());

  const auto twice = perturbed(once, mirror);
  EXPECT_EQ(twice->rig(), ramp->rig());
  EXPECT_EQ(cv::norm(twice->frame(5).left, ramp->frame(5).left, cv::NORM_INF), 0);
  EXPECT_EQ(twice->objects(5)->at(0).box_px, cv::Rect2d(40, 5, 20, 10));
}

TEST(Perturbation, AMirroredLabelIsToleratedWhereItIsNotKnown) {
  const auto ramp = std::make_shared<const Ramp>();
  ObjectLabel label = ramp->objects(0)->at(0);
  label.distance_m.reset();
  EXPECT_FALSE(mirrored(label, ramp->rig()).isDemanded()) << "without a distance";
  label.distance_m = 8;
  label.box_px.x = -2;
  EXPECT_FALSE(mirrored(label, ramp->rig()).isDemanded())
      << "the right camera sees 5 of 20 columns";
}

TEST(Perturbation, FramesAreLeftOut) {
  const auto ramp = std::make_shared<const Ramp>();
  Perturbation odd = change();
  odd.every = 2;
  odd.first = 1;
  const auto half = perturbed(ramp, odd);
  ASSERT_EQ(half->frames(), 6);
  EXPECT_EQ(half->fileNumber(2), 105);
  EXPECT_DOUBLE_EQ(half->stamp_s(2), ramp->stamp_s(5));
  Perturbation dropping = change();
  dropping.drop_every = 7;
  const auto dropped = perturbed(ramp, dropping);
  ASSERT_EQ(dropped->frames(), kFrames - 1);
  EXPECT_EQ(dropped->fileNumber(4), 104);
  EXPECT_EQ(dropped->fileNumber(5), 106);
}

TEST(Perturbation, NoiseHasItsSigmaAndIsTheSameAgain) {
  const auto ramp = std::make_shared<const Ramp>();
  Perturbation noise = change();
  noise.noise_sigma = 2;
  const auto noisy = perturbed(ramp, noise);
  cv::Mat1f difference;
  cv::subtract(noisy->frame(5).left, ramp->frame(5).left, difference, {}, CV_32F);
  cv::Scalar mean, deviation;
  cv::meanStdDev(difference, mean, deviation);
  EXPECT_NEAR(mean[0], 0, 0.2);
  EXPECT_NEAR(deviation[0], 2, 0.2) << "2000 pixels";
  EXPECT_EQ(cv::norm(noisy->frame(5).left, noisy->frame(5).left, cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(noisy->frame(5).left, noisy->frame(6).left, cv::NORM_INF), 10);
}

TEST(Perturbation, ColumnsAreOffByAsMuchInTheCorner) {
  const auto ramp = std::make_shared<const Ramp>();
  Perturbation off = change();
  off.column_offset_px = 4;
  const auto shifted = perturbed(ramp, off);
  EXPECT_EQ(cv::norm(shifted->frame(0).left, ramp->frame(0).left, cv::NORM_INF), 0);
  // Lower left: column x has the grey level of x + 4 px, which grows by 1 in 2 px.
  EXPECT_NEAR(shifted->frame(0).right(19, 0), ramp->frame(0).right(19, 4), 1);
  EXPECT_NEAR(shifted->frame(0).right(10, 50), ramp->frame(0).right(10, 50), 1);
}

TEST(Perturbation, ColumnsAreOffAtTheBorders) {
  const auto ramp = std::make_shared<const Ramp>();
  Perturbation bow = change();
  bow.column_bow_px = 4;
  const auto bowed = perturbed(ramp, bow);
  EXPECT_NEAR(bowed->frame(0).right(7, 0), ramp->frame(0).right(7, 4), 1);
  EXPECT_NEAR(bowed->frame(0).right(7, 95), ramp->frame(0).right(7, 98), 1);
  EXPECT_EQ(bowed->frame(0).right(7, 50), ramp->frame(0).right(7, 50));
}

TEST(Perturbation, ColumnsJumpInTheMiddleOfTheSequence) {
  const auto ramp = std::make_shared<const Ramp>();
  Perturbation jump = change();
  jump.column_jump_px = 2;
  const auto jumped = perturbed(ramp, jump);
  EXPECT_EQ(cv::norm(jumped->frame(5).right, ramp->frame(5).right, cv::NORM_INF), 0);
  for (int x = 0; x < 98; ++x)
    ASSERT_EQ(jumped->frame(6).right(7, x), ramp->frame(6).right(7, x + 2)) << x;
  EXPECT_EQ(cv::norm(jumped->frame(6).left, ramp->frame(6).left, cv::NORM_INF), 0);
}

TEST(Perturbation, TheRightImageAloneIsDarker) {
  const auto ramp = std::make_shared<const Ramp>();
  Perturbation dark = change();
  dark.right_gain = 0.5;
  const auto darker = perturbed(ramp, dark);
  EXPECT_EQ(cv::norm(darker->frame(5).left, ramp->frame(5).left, cv::NORM_INF), 0);
  EXPECT_EQ(darker->frame(5).right(7, 60), ramp->frame(5).right(7, 60) / 2);
}

TEST(Perturbation, RememberedSequencesHaveTheLabelsOfFiles) {
  Ramp ramp;
  EXPECT_EQ(loadIntoMemory(ramp, 0)->objects(3)->at(0).type, "car");
  ObjectLabel label;
  label.frame = 103;
  label.type = "van";
  ramp.setLabels({label});
  const auto known = loadIntoMemory(ramp, 5);
  ASSERT_EQ(known->frames(), 5);
  EXPECT_TRUE(known->objects(2)->empty());
  ASSERT_EQ(known->objects(3)->size(), 1u);
  EXPECT_EQ(known->objects(3)->at(0).type, "van");
}

}  // namespace
}  // namespace predictive_stereo
