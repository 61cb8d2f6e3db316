/// What the pose and its covariance say while the camera does not see, and afterwards.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "evaluation/simulation/street.h"
#include "predictive_stereo/pipeline.h"
#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {
namespace {

constexpr int kFrames = 45;

// Rendered once. As small as ego-motion allows.
struct Film {
  StereoRig rig;
  std::vector<StreetFrame> frames;

  explicit Film(const std::string& scene) {
    StreetParams params;
    params.scene = scene;
    params.width = 496;
    params.height = 160;
    const Street street(params);
    rig = street.rig();
    for (int i = 0; i < kFrames; ++i) frames.push_back(street.render(i));
  }
};

/// Drives through a film and compares the pose with the true one.
class LostPose : public testing::TestWithParam<const char*> {
 protected:
  enum Fault { kNone, kBlack, kSwapped, kMissing };

  static const Film& film() {
    static std::map<std::string, Film> films;
    return films.try_emplace(GetParam(), GetParam()).first->second;
  }
  void drive(Fault fault, int frames) {
    const cv::Mat1b black(film().rig.size, uchar{0});
    for (int i = 0; i < frames; ++i) {
      const StreetFrame& now = film().frames.at(static_cast<size_t>(number_++));
      if (fault == kMissing) continue;
      StereoFrame frame{now.left, now.right, film().rig, stampFromSeconds(now.stamp_s)};
      if (fault == kBlack) frame.left = frame.right = black;
      if (fault == kSwapped) std::swap(frame.left, frame.right);
      output_ = odometry_.process(frame);
      states_.push_back(output_.pose.state);
      if (fault != kNone) {
        EXPECT_NE(output_.pose.state, PoseState::kKnown) << number_;
      }
      if (number_ > 1) expectWithinThreeSigma(now);
    }
  }
  void expectWithinThreeSigma(const StreetFrame& now) {
    const Eigen::Isometry3d T_first_cam =
        relative(film().frames.front().T_world_cam, now.T_world_cam);
    const Eigen::Isometry3d off = relative(output_.pose.T_odom_cam, T_first_cam);
    const Eigen::AngleAxisd turn(off.linear());
    Vector6d error;
    error << off.translation(), turn.angle() * turn.axis();
    const Vector6d sigma = output_.pose.covariance.diagonal().cwiseSqrt();
    for (int i = 0; i < 6; ++i)
      EXPECT_LE(std::abs(error(i)), 3 * sigma(i)) << "axis " << i << ", frame " << number_ - 1;
  }
  double sigma_m() const {
    return std::sqrt(output_.pose.covariance.topLeftCorner<3, 3>().trace());
  }

  int number_ = 0;
  VisualOdometry odometry_{EgoMotionParams(), PipelineParams().max_gap};
  OdometryOutput output_;
  std::vector<PoseState> states_;
};

TEST_P(LostPose, IsKnownAgainWhereTheOldViewIsFoundAgain) {
  drive(kNone, 12);
  const double before_m = sigma_m();
  drive(kBlack, 1);
  drive(kNone, 1);
  EXPECT_EQ(output_.pose.state, PoseState::kKnown);
  EXPECT_EQ(output_.ego_motion.frames, 2);
  EXPECT_LT(sigma_m(), 2 * before_m + 0.02);
}

TEST_P(LostPose, StaysUncertainAfterALongLoss) {
  for (const Fault fault : {kBlack, kSwapped}) {
    odometry_.reset();
    number_ = 0;
    drive(kNone, 6);
    drive(fault, 15);
    const double lost_m = sigma_m();
    drive(kNone, 4);
    EXPECT_EQ(output_.pose.state, PoseState::kKnown);
    EXPECT_GE(sigma_m(), 0.99 * lost_m);
    drive(fault, 15);
    drive(kNone, 4);
    EXPECT_GE(sigma_m(), 1.2 * lost_m);
  }
}

TEST_P(LostPose, StaysUncertainAfterAGap) {
  drive(kNone, 6);
  drive(kMissing, 20);
  drive(kNone, 4);
  EXPECT_EQ(output_.pose.state, PoseState::kKnown);
  EXPECT_GE(sigma_m(), 0.3);
}

// The first frame is the origin even if the images are swapped; later ones have no view.
TEST_P(LostPose, SwappedImagesAreNoOrigin) {
  output_ =
      odometry_.process({film().frames[0].right, film().frames[0].left, film().rig, Stamp(0)});
  EXPECT_EQ(output_.pose.state, PoseState::kKnown);
  EXPECT_TRUE(output_.ego_motion.swapped);
  number_ = 1;
  drive(kSwapped, 24);
}

INSTANTIATE_TEST_SUITE_P(Streets, LostPose, testing::Values("straight", "turn"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace predictive_stereo
