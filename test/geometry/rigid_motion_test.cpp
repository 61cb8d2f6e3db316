#include "predictive_stereo/rigid_motion.h"

#include <gtest/gtest.h>

#include <random>

namespace predictive_stereo {
namespace {

double deviationFromRotation(const Eigen::Isometry3d& T) {
  return (T.linear() * T.linear().transpose() - Eigen::Matrix3d::Identity()).norm();
}

class Motions {
 public:
  Eigen::Isometry3d next() {
    const auto uniform = [this] { return std::uniform_real_distribution<double>(-1, 1)(random_); };
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() =
        Eigen::AngleAxisd(0.1 * uniform(), Eigen::Vector3d(uniform(), uniform(), 1).normalized())
            .toRotationMatrix();
    T.translation() << uniform(), uniform(), uniform();
    return T;
  }

 private:
  std::mt19937 random_{1};
};

TEST(RigidMotion, ComposesAndTakesApart) {
  Motions motions;
  const Eigen::Isometry3d T_a_b = motions.next(), T_b_c = motions.next();
  const Eigen::Isometry3d T_a_c = compose(T_a_b, T_b_c);
  EXPECT_TRUE(T_a_c.isApprox(T_a_b * T_b_c, 1e-14));
  EXPECT_TRUE(relative(T_a_b, T_a_c).isApprox(T_b_c, 1e-14));
}

TEST(RigidMotion, AMillionProductsLeaveARotation) {
  Motions motions;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (int i = 0; i < 1000000; ++i) pose = compose(pose, motions.next());
  EXPECT_LT(deviationFromRotation(pose), 1e-14);
}

// As in ego-motion at rest: each motion is computed from the expectation and the last pose, and
// gives the next expectation. Without orthonormal() the error is visible after 34 rounds.
TEST(RigidMotion, AFeedbackOfAMillionProductsLeavesARotation) {
  Motions motions;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity(), last = motions.next();
  last.translation() *= 1e-3;
  const Eigen::Isometry3d first = last;
  for (int i = 0; i < 1000000; ++i) {
    const Eigen::Isometry3d expected = compose(last, pose);
    last = compose(expected, pose.inverse());
    pose = expected;
    ASSERT_LT(deviationFromRotation(last), 1e-13) << "after " << i << " products";
  }
  EXPECT_LT((last.linear() - first.linear()).norm(), 1e-6);
}

}  // namespace
}  // namespace predictive_stereo
