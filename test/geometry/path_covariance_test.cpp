#include "predictive_stereo/path_covariance.h"

#include <gtest/gtest.h>

#include <cmath>

namespace predictive_stereo {
namespace {

// One metre ahead per motion, with noise of 1 cm in this direction.
CameraMotion metre() {
  CameraMotion motion;
  motion.T_cam_prev.translation().z() = -1;
  motion.covariance(2, 2) = 1e-4;
  return motion;
}

double sigmaAlongTheWay(const PathCovariance& path) { return std::sqrt(path.covariance()(2, 2)); }

TEST(PathCovariance, NoiseGrowsWithTheRootOfTheNumberOfMotions) {
  PathCovariance path;
  for (int i = 0; i < 25; ++i) path.add(metre(), CommonErrors::Zero());
  EXPECT_NEAR(sigmaAlongTheWay(path), 0.05, 1e-12);
}

TEST(PathCovariance, CommonErrorsGrowWithTheNumber) {
  CameraMotion motion = metre();
  CommonErrors scale = CommonErrors::Zero();
  scale(2, 3) = 0.01;  // all of the noise is common
  PathCovariance path;
  for (int i = 0; i < 25; ++i) path.add(motion, scale);
  EXPECT_NEAR(sigmaAlongTheWay(path), 0.25, 1e-12);
}

TEST(PathCovariance, CommonErrorsCancelOnTheWayBack) {
  CommonErrors ahead = CommonErrors::Zero(), back = ahead;
  ahead(2, 3) = 0.01;
  back(2, 3) = -0.01;
  CameraMotion reverse = metre();
  reverse.T_cam_prev.translation().z() = 1;
  PathCovariance path;
  for (int i = 0; i < 25; ++i) path.add(metre(), ahead);
  for (int i = 0; i < 25; ++i) path.add(reverse, back);
  EXPECT_NEAR(sigmaAlongTheWay(path), 0, 1e-9);
}

// An error of the direction moves the end of the path sideways.
TEST(PathCovariance, RotationsMoveWhatIsFarther) {
  CameraMotion turn;
  turn.covariance(4, 4) = 1e-6;
  PathCovariance path;
  path.add(turn, CommonErrors::Zero());
  for (int i = 0; i < 10; ++i) path.add(metre(), CommonErrors::Zero());
  EXPECT_NEAR(std::sqrt(path.covariance()(0, 0)), 0.01, 1e-12);
}

}  // namespace
}  // namespace predictive_stereo
