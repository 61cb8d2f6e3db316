#include "evaluation/odometry_evaluation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace predictive_stereo {
namespace {

TEST(EvaluateOdometry, MeasuresTheStreet) {
  StreetParams params;
  params.scene = "straight";
  params.frames = 6;
  const auto street = streetSequence(params);
  const OdometryEvaluation e = evaluateOdometry(*street, EgoMotionParams{});
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
    Blind() : Sequence("blind") {}
    int frames() const override { return 1; }
    SequenceFrame frame(int) const override { return {}; }
  };
  EXPECT_THROW(evaluateOdometry(Blind(), EgoMotionParams{}), std::runtime_error);
}

Eigen::Isometry3d forward(double step_m, double yaw_rad = 0) {
  Eigen::Isometry3d T_prev_cam = Eigen::Isometry3d::Identity();
  T_prev_cam.linear() = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitY()).toRotationMatrix();
  T_prev_cam.translation().z() = step_m;
  return T_prev_cam.inverse();
}

// Poses of equal motions T_cam_prev.
Poses poses(size_t motions, const Eigen::Isometry3d& motion) {
  Poses poses{Eigen::Isometry3d::Identity()};
  while (poses.size() <= motions) poses.push_back(poses.back() * motion.inverse());
  return poses;
}

TEST(PoseMetrics, ScaleAndYawErrorsByHand) {
  const Poses truth = poses(20, forward(1.0));
  const Poses longer = poses(20, forward(1.02));
  const auto errors = relativePoseErrors(longer, truth, {5, 10, 100});
  ASSERT_EQ(errors.size(), 3u);
  EXPECT_EQ(errors[0].stretches, 16);
  EXPECT_NEAR(errors[0].translation_percent, 2, 1e-9);
  EXPECT_NEAR(errors[1].translation_percent, 2, 1e-9);
  EXPECT_EQ(errors[2].stretches, 0);

  const Poses turning = poses(20, forward(1.0, 0.01));
  EXPECT_NEAR(relativePoseErrors(turning, truth, {10})[0].rotation_deg_per_m, 0.01 * 180 / M_PI,
              1e-9);
  const MotionError mean = meanMotionError(turning, truth);
  EXPECT_NEAR(mean.rotation_rad, 0.01, 1e-9);
  EXPECT_NEAR(mean.translation_m, 0.0, 0.011);
  EXPECT_THROW(relativePoseErrors(turning, poses(19, forward(1.0)), {10}), std::invalid_argument);
}

TEST(PoseMetrics, NormalizedErrorIsSixOnAverage) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  CameraMotion estimated;
  estimated.T_cam_prev = forward(1.0, 0.05);
  Vector6d sigma;
  sigma << 0.01, 0.02, 0.03, 1e-4, 2e-4, 3e-4;
  Matrix6d mix = Matrix6d::Identity();
  mix(0, 4) = 0.5;
  const Matrix6d root = mix * sigma.asDiagonal();
  estimated.covariance = root * root.transpose();
  double sum = 0;
  constexpr int kDraws = 5000;
  for (int i = 0; i < kDraws; ++i) {
    Vector6d e;
    for (int k = 0; k < 6; ++k) e[k] = normal(random);
    e = root * e;
    Eigen::Isometry3d perturbation = Eigen::Isometry3d::Identity();
    perturbation.linear() =
        Eigen::AngleAxisd(e.tail<3>().norm(), e.tail<3>().normalized()).toRotationMatrix();
    perturbation.translation() = e.head<3>();
    sum += normalizedErrorSquared(estimated, perturbation * estimated.T_cam_prev);
  }
  EXPECT_NEAR(sum / kDraws, 6, 0.2);
  estimated.covariance.setZero();
  EXPECT_THROW(normalizedErrorSquared(estimated, estimated.T_cam_prev), std::invalid_argument);
}

}  // namespace
}  // namespace predictive_stereo
