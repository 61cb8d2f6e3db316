/// A rotation prior of another sensor helps in fast turns, and does no harm if it is wrong.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "evaluation/simulation/street.h"
#include "odometry/simulated_gyro.h"
#include "predictive_stereo/ego_motion.h"
#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {
namespace {

constexpr double kDegree = 3.14159265358979 / 180;

struct Errors {
  int lost = 0;
  double mean_m = 0, mean_rad = 0;
};

// Frames first, first + step, ... of a scene at 10 Hz, rendered once.
class Clip {
 public:
  Clip(const std::string& scene, int first, int last, int step) : street_(params(scene, last + 1)) {
    for (int k = first; k <= last; k += step) frames_.push_back(street_.render(k));
  }

  Errors follow(const std::string& kind) const {
    EgoMotion ego_motion{EgoMotionParams()};
    SimulatedGyro prior(kind);
    Errors errors;
    for (size_t i = 0; i < frames_.size(); ++i) {
      const StreetFrame& frame = frames_[i];
      if (i == 0) {
        ego_motion.estimate(frame.left, frame.right, street_.rig());
        continue;
      }
      const auto T_true = [&](size_t from) {
        return relative(frame.T_world_cam, frames_[from].T_world_cam);
      };
      const EgoMotionEstimate estimate =
          ego_motion.estimate(frame.left, frame.right, street_.rig(), {},
                              prior.next(T_true(i - 1), frame.stamp_s - frames_[i - 1].stamp_s));
      if (estimate.state != PoseState::kKnown) {
        ++errors.lost;
        continue;
      }
      const Eigen::Isometry3d off =
          relative(T_true(i - static_cast<size_t>(estimate.frames)), estimate.motion.T_cam_prev);
      const auto motions = static_cast<double>(frames_.size() - 1);
      errors.mean_m += off.translation().norm() / motions;
      errors.mean_rad += Eigen::AngleAxisd(off.linear()).angle() / motions;
    }
    return errors;
  }

 private:
  static StreetParams params(const std::string& scene, int frames) {
    StreetParams params;
    params.scene = scene;
    params.frames = frames;
    params.rate_hz = 10;
    return params;
  }

  Street street_;
  std::vector<StreetFrame> frames_;
};

// It tilts by 14 and 19 degrees between two frames.
const Clip& drone() {
  static const Clip clip("drone", 112, 126, 2);
  return clip;
}

TEST(RotationPrior, HelpsADroneThatLooksDownQuickly) {
  const Errors alone = drone().follow("none"), helped = drone().follow("gyro");
  EXPECT_GT(alone.lost, 0) << "too easy to show anything";
  EXPECT_EQ(helped.lost, 0);
  EXPECT_LT(helped.mean_rad, 0.1 * kDegree);
  EXPECT_LT(helped.mean_m, 0.01);
}

TEST(RotationPrior, DoesNoHarmWhereItIsWrong) {
  for (const char* scene : {"handheld", "fast_rotation"}) {
    const Clip clip(scene, 30, 48, 2);
    const Errors alone = clip.follow("none");
    for (const std::string& kind : SimulatedGyro::kinds()) {
      SCOPED_TRACE(scene + (", " + kind));
      const Errors told = clip.follow(kind);
      EXPECT_LE(told.lost, alone.lost);
      EXPECT_LT(told.mean_m, 1.1 * alone.mean_m + 1e-4);
      EXPECT_LT(told.mean_rad, 1.1 * alone.mean_rad + 0.001 * kDegree);
    }
  }
}

TEST(RotationPrior, WhatIsNoRotationIsNotTaken) {
  const Errors alone = drone().follow("none"), told = drone().follow("nan");
  EXPECT_EQ(told.lost, alone.lost);
  EXPECT_EQ(told.mean_m, alone.mean_m);
  EXPECT_EQ(told.mean_rad, alone.mean_rad);
}

}  // namespace
}  // namespace predictive_stereo
