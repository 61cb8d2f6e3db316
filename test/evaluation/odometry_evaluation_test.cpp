#include "evaluation/odometry_evaluation.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace predictive_stereo {
namespace {

TEST(EvaluateOdometry, MeasuresTheStreet) {
  StreetParams params;
  params.scene = "straight";
  params.frames = 6;
  const auto street = streetSequence(params);
  const OdometryEvaluation e = evaluateOdometry(*street, EgoMotionParams{});
  EXPECT_EQ(e.motions.size(), 5u);
  EXPECT_EQ(e.estimated.size(), 6u);
  EXPECT_EQ(e.lost, 0);
  EXPECT_GT(e.length_m, 1);
  EXPECT_LT(std::abs(e.length_error_percent), 1);
  EXPECT_LT(e.mean.translation_m, 0.02);
  EXPECT_GT(e.mean_normalized_error, 0);
  const std::string paths = pathsCsv({e});
  EXPECT_EQ(std::count(paths.begin(), paths.end(), '\n'), 7);
  EXPECT_NE(paths.find("\nstreet straight,5,"), std::string::npos) << paths;
}

TEST(EvaluateOdometry, NeedsTruePoses) {
  class Blind : public Sequence {
   public:
    const std::string& name() const override { return name_; }
    const StereoRig& rig() const override { return rig_; }
    int frames() const override { return 1; }
    SequenceFrame frame(int) const override { return {}; }

   private:
    std::string name_ = "blind";
    StereoRig rig_;
  };
  EXPECT_THROW(evaluateOdometry(Blind(), EgoMotionParams{}), std::runtime_error);
}

}  // namespace
}  // namespace predictive_stereo
