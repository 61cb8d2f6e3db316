#include "odometry/pose_solver.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <opencv2/core/utility.hpp>
#include <random>

namespace predictive_stereo {
namespace {

StereoRig kittiRig() {
  StereoRig rig;
  rig.size = {1242, 375};
  rig.fx_px = rig.fy_px = 721.5;
  rig.cx_left_px = rig.cx_right_px = 609.5;
  rig.cy_px = 172.8;
  rig.baseline_m = 0.537;
  return rig;
}

Eigen::Isometry3d motion(const Eigen::Vector3d& t_m, const Eigen::Vector3d& r_rad) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = t_m;
  if (r_rad.norm() > 0)
    T.linear() = Eigen::AngleAxisd(r_rad.norm(), r_rad.normalized()).toRotationMatrix();
  return T;
}

const Eigen::Isometry3d kDriving = motion({0.02, -0.01, -1.1}, {0.002, 0.02, -0.001});

// Points of a street before and after the motion `T`, with noise on the five measured coordinates
// (previous x and y define the point).
std::vector<Correspondence> observe(const StereoRig& rig, const Eigen::Isometry3d& T, int n,
                                    double sigma_px, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::normal_distribution<double> noise(0, 1);
  std::vector<Correspondence> all;
  while (static_cast<int>(all.size()) < n) {
    const double depth_m = 1 / (1 / 60.0 + uniform(random) * (1 / 5.0 - 1 / 60.0));
    const Eigen::Vector3d previous(uniform(random) * rig.size.width,
                                   uniform(random) * rig.size.height,
                                   rig.disparityTimesDepth() / depth_m);
    const Eigen::Vector3d moved_m =
        T * rig.pointFromDisparity(previous.x(), previous.y(), previous.z());
    if (moved_m.z() < 1) continue;
    Correspondence c;
    c.previous = previous + Eigen::Vector3d(0, 0, sigma_px * noise(random));
    c.current = rig.disparityFromPoint(moved_m) +
                sigma_px * Eigen::Vector3d(noise(random), noise(random), noise(random));
    all.push_back(c);
  }
  return all;
}

Vector6d errorOf(const Eigen::Isometry3d& estimated, const Eigen::Isometry3d& truth) {
  const Eigen::Isometry3d delta = estimated * truth.inverse();
  const Eigen::AngleAxisd rotation(delta.linear());
  Vector6d error;
  error << delta.translation(), rotation.angle() * rotation.axis();
  return error;
}

TEST(PoseSolver, ExactOnExactObservations) {
  const StereoRig rig = kittiRig();
  for (const auto& T :
       {kDriving, motion({0, 0, 0}, {0, 0, 0}), motion({0.3, 0, 0.1}, {0, 0.4, 0})}) {
    const auto all = observe(rig, T, 200, 0, 1);
    const PoseSolution solution = solvePose(rig, all, Eigen::Isometry3d::Identity(),
                                            DisparityOffset(), 0.3, PoseSolverParams());
    ASSERT_TRUE(solution.found);
    EXPECT_EQ(solution.inliers, 200);
    EXPECT_LT(errorOf(solution.T_cam_prev, T).norm(), 1e-7);
  }
}

TEST(PoseSolver, CovarianceTellsTheError) {
  const StereoRig rig = kittiRig();
  double sum = 0;
  constexpr int kRuns = 300;
  for (unsigned run = 0; run < kRuns; ++run) {
    const auto all = observe(rig, kDriving, 150, 0.2, run);
    const PoseSolution solution =
        solvePose(rig, all, kDriving, DisparityOffset(), 0.3, PoseSolverParams());
    ASSERT_TRUE(solution.found);
    EXPECT_NEAR(solution.sigma_px, 0.2, 0.06);
    const Vector6d error = errorOf(solution.T_cam_prev, kDriving);
    sum += error.dot(solution.covariance.inverse() * error) / 6;
  }
  EXPECT_GT(sum / kRuns, 0.8);
  EXPECT_LT(sum / kRuns, 1.25);
}

TEST(PoseSolver, OutliersAndAMoverDoNotMatter) {
  const StereoRig rig = kittiRig();
  auto all = observe(rig, kDriving, 150, 0.1, 1);
  // An overtaking lorry: its rigid motion is as consistent as that of the street.
  const auto lorry = observe(rig, motion({0.1, 0, 0.4}, {0, 0, 0}), 100, 0.1, 2);
  all.insert(all.end(), lorry.begin(), lorry.end());
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0, 100);
  for (int i = 0; i < 50; ++i) {
    all.push_back(all[i]);
    all.back().current += Eigen::Vector3d(uniform(random), uniform(random), uniform(random));
  }
  const PoseSolution solution = solvePose(rig, all, Eigen::Isometry3d::Identity(),
                                          DisparityOffset(), 0.3, PoseSolverParams());
  ASSERT_TRUE(solution.found);
  EXPECT_LT(errorOf(solution.T_cam_prev, kDriving).head<3>().norm(), 0.005);
  EXPECT_LT(errorOf(solution.T_cam_prev, kDriving).tail<3>().norm(), 2e-4);
  int lorry_inliers = 0;
  for (size_t i = 150; i < 250; ++i) lorry_inliers += solution.inlier[i];
  EXPECT_LT(lorry_inliers, 5);
}

TEST(PoseSolver, PointsKnownToBeStaticOutvoteAMoverThatFillsTheView) {
  const StereoRig rig = kittiRig();
  auto all = observe(rig, kDriving, 80, 0.1, 1);
  auto mover = observe(rig, motion({0.1, 0, 0.4}, {0, 0, 0}), 120, 0.1, 2);
  for (Correspondence& c : mover) c.trust = 0.5;
  all.insert(all.end(), mover.begin(), mover.end());
  const PoseSolution solution = solvePose(rig, all, Eigen::Isometry3d::Identity(),
                                          DisparityOffset(), 0.3, PoseSolverParams());
  ASSERT_TRUE(solution.found);
  EXPECT_LT(errorOf(solution.T_cam_prev, kDriving).head<3>().norm(), 0.01);
}

TEST(PoseSolver, AnUnlikelyMotionMustExplainFarMorePoints) {
  const StereoRig rig = kittiRig();
  const Eigen::Isometry3d along = motion({0.1, 0, -0.1}, {0, 0, 0});
  for (const auto& [movers, wins] : {std::pair(120, false), std::pair(500, true)}) {
    auto all = observe(rig, kDriving, 80, 0.1, 1);
    const auto vehicles = observe(rig, along, movers, 0.1, 2);
    all.insert(all.end(), vehicles.begin(), vehicles.end());
    PoseSolverParams params;
    const auto error_m = [&](const Eigen::Isometry3d& truth) {
      const PoseSolution solution = solvePose(rig, all, kDriving, DisparityOffset(), 0.3, params);
      return errorOf(solution.T_cam_prev, truth).head<3>().norm();
    };
    EXPECT_LT(error_m(along), 0.02) << "more points move along than stand";
    params.likely_position_m = kDriving.inverse().translation();
    params.likely_radius_m = 0.3;
    EXPECT_LT(error_m(wins ? along : kDriving), 0.02) << movers;
  }
}

// A person at 2 m before a small camera that stands. A turn to the side and a move against it
// explain the person, and the background to a few tenths of a pixel.
TEST(PoseSolver, APersonBeforeAFarBackgroundIsNotTheCamera) {
  StereoRig rig = kittiRig();
  rig.size = {320, 240};
  rig.fx_px = rig.fy_px = 260;
  rig.cx_left_px = rig.cx_right_px = 160;
  rig.cy_px = 120;
  rig.baseline_m = 0.12;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::normal_distribution<double> noise(0, 0.1);
  std::vector<Correspondence> all;
  for (int i = 0; i < 400; ++i) {
    const bool person = i < 100;
    const double depth_m = person ? 1.8 + 0.4 * uniform(random) : 10 + 10 * uniform(random);
    Correspondence c;
    c.previous << (person ? 80 + 100 * uniform(random) : 320 * uniform(random)),
        240 * uniform(random), rig.disparityTimesDepth() / depth_m;
    c.current = c.previous + Eigen::Vector3d(noise(random), noise(random), noise(random));
    if (person) c.current.x() -= 0.11 / depth_m * rig.fx_px;
    all.push_back(c);
  }
  const PoseSolution solution = solvePose(rig, all, Eigen::Isometry3d::Identity(),
                                          DisparityOffset(), 0.3, PoseSolverParams());
  ASSERT_TRUE(solution.found);
  EXPECT_LT(solution.T_cam_prev.translation().norm(), 0.01);
}

TEST(PoseSolver, FarPointsAloneGiveTheRotation) {
  const StereoRig rig = kittiRig();
  auto all = observe(rig, kDriving, 100, 0.1, 1);
  auto far = observe(rig, motion({0, 0, 0}, {0.002, 0.02, -0.001}), 100, 0.1, 2);
  for (Correspondence& c : far) {  // at infinity, where a converging rig measures d < 0
    const Eigen::Vector3d ray = rig.pointFromDisparity(c.previous.x(), c.previous.y(), 1);
    c.current.head<2>() = rig.disparityFromPoint(kDriving.linear() * ray).head<2>();
    c.previous.z() = c.current.z() = -0.1;
  }
  all.insert(all.end(), far.begin(), far.end());
  const PoseSolution solution = solvePose(rig, all, Eigen::Isometry3d::Identity(),
                                          DisparityOffset(), 0.3, PoseSolverParams());
  ASSERT_TRUE(solution.found);
  EXPECT_LT(errorOf(solution.T_cam_prev, kDriving).tail<3>().norm(), 2e-4);
  EXPECT_GT(solution.inliers, 180);
}

// Points of disparity 0, measured with noise: some disparities are positive by chance.
std::vector<Correspondence> observeInfinity(const StereoRig& rig, const Eigen::Isometry3d& T, int n,
                                            double sigma_px, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, sigma_px);
  auto all = observe(rig, T, n, 0, seed);
  for (Correspondence& c : all) {
    const Eigen::Vector3d ray = rig.pointFromDisparity(c.previous.x(), c.previous.y(), 1);
    c.current = rig.disparityFromPoint(T.linear() * ray);
    c.current.z() = noise(random);
    c.current.head<2>() += Eigen::Vector2d(noise(random), noise(random));
    c.previous.z() = noise(random);
  }
  return all;
}

// The noise of a disparity is no information about the translation.
TEST(PoseSolver, PointsAtInfinityDoNotGiveTheTranslation) {
  const StereoRig rig = kittiRig();
  for (const double variance_px2 : {0.0, 1.0}) {
    for (unsigned run = 0; run < 50; ++run) {
      const auto all = observeInfinity(rig, kDriving, 200, 0.1, run);
      const PoseSolution solution = solvePose(rig, all, Eigen::Isometry3d::Identity(),
                                              {0, variance_px2}, 0.3, PoseSolverParams());
      EXPECT_FALSE(solution.found)
          << errorOf(solution.T_cam_prev, kDriving).head<3>().norm() << " m, sigma "
          << std::sqrt(solution.covariance.topLeftCorner<3, 3>().trace()) << " m";
    }
  }
}

// Solutions of 200 scenes, and the mean of e'C^-1e / 3 of their translations' errors e.
struct Solutions {
  int found = 0;
  double normalised_error = 0;

  template <class Observe>
  explicit Solutions(const StereoRig& rig, const Observe& observe_run) {
    for (unsigned run = 0; run < 200; ++run) {
      const PoseSolution solution = solvePose(rig, observe_run(run), Eigen::Isometry3d::Identity(),
                                              DisparityOffset(), 0.3, PoseSolverParams());
      if (!solution.found) continue;
      ++found;
      const Eigen::Vector3d error_m = errorOf(solution.T_cam_prev, kDriving).head<3>();
      const Eigen::Matrix3d covariance_m2 = solution.covariance.topLeftCorner<3, 3>();
      normalised_error += error_m.dot(covariance_m2.inverse() * error_m) / 3;
    }
    normalised_error /= std::max(found, 1);
  }
};

TEST(PoseSolver, PointsAtInfinityDoNotMakeTheTranslationLookCertain) {
  const StereoRig rig = kittiRig();
  for (const int near : {5, 10, 20, 40, 100}) {
    const Solutions solutions(rig, [&](unsigned run) {
      auto all = observeInfinity(rig, kDriving, 200, 0.1, run);
      const auto others = observe(rig, kDriving, near, 0.1, run + 1000);
      all.insert(all.end(), others.begin(), others.end());
      return all;
    });
    EXPECT_GT(solutions.found, 150) << near;
    EXPECT_GT(solutions.normalised_error, 0.8) << near;
    EXPECT_LT(solutions.normalised_error, 1.25) << near;
  }
}

// Noise of disparities shortens the translation.
TEST(PoseSolver, FarPointsDoNotMakeTheTranslationLookCertain) {
  for (const double farther : {5, 20, 50, 100, 150}) {
    StereoRig rig = kittiRig();
    rig.baseline_m /= farther;
    const Solutions solutions(rig,
                              [&](unsigned run) { return observe(rig, kDriving, 200, 0.1, run); });
    EXPECT_GT(solutions.found, 190) << farther;
    EXPECT_GT(solutions.normalised_error, 0.8) << farther;
    EXPECT_LT(solutions.normalised_error, 1.25) << farther;
  }
}

// Measured disparities are too small by the offset.
std::vector<Correspondence> withOffset(std::vector<Correspondence> all, double offset_px) {
  for (Correspondence& c : all) {
    c.previous.z() -= offset_px;
    c.current.z() -= offset_px;
  }
  return all;
}

TEST(PoseSolver, TellsTheOffsetAndHowWellItIsKnown) {
  const StereoRig rig = kittiRig();
  PoseSolverParams params;
  params.offset_jitter_px = 0.3;
  const DisparityOffset unknown{0, 1};
  double sum = 0, sigma_px = 0;
  constexpr int kRuns = 200;
  for (unsigned run = 0; run < kRuns; ++run) {
    const auto all = withOffset(observe(rig, kDriving, 150, 0.2, run), 1.5);
    const PoseSolution solution = solvePose(rig, all, kDriving, unknown, 0.3, params);
    ASSERT_TRUE(solution.found);
    const double error_px = solution.offset.offset_px - 1.5;
    sum += error_px * error_px / solution.offset.variance_px2;
    sigma_px += std::sqrt(solution.offset.variance_px2) / kRuns;
  }
  EXPECT_LT(sigma_px, 0.2);
  EXPECT_GT(sum / kRuns, 0.7);
  EXPECT_LT(sum / kRuns, 1.4);
}

// If the camera only rotates, or stands, the offset is not observable: it stays as uncertain.
TEST(PoseSolver, LearnsNoOffsetWithoutParallax) {
  const StereoRig rig = kittiRig();
  PoseSolverParams params;
  params.offset_jitter_px = 0.3;
  for (const auto& T : {motion({0, 0, 0}, {0, 0, 0}), motion({0, 0, 0.002}, {0.01, 0.05, -0.02})}) {
    DisparityOffset offset{0, 1};
    for (unsigned frame = 0; frame < 50; ++frame) {
      const auto all = withOffset(observe(rig, T, 150, 0.2, frame), 1.5);
      const PoseSolution solution = solvePose(rig, all, T, offset, 0.3, params);
      ASSERT_TRUE(solution.found);
      ASSERT_GE(solution.offset.variance_px2, offset.variance_px2);
      offset = solution.offset;
    }
    EXPECT_NEAR(offset.offset_px, 0, 0.3);
    EXPECT_LT(offset.variance_px2, 1.2);
  }
}

TEST(PoseSolver, TooFewOrContradictoryPointsGiveNothing) {
  const StereoRig rig = kittiRig();
  const auto few = observe(rig, kDriving, 8, 0, 1);
  EXPECT_FALSE(solvePose(rig, few, kDriving, DisparityOffset(), 0.3, PoseSolverParams()).found);
  EXPECT_FALSE(solvePose(rig, {}, kDriving, DisparityOffset(), 0.3, PoseSolverParams()).found);
  auto nonsense = observe(rig, kDriving, 12, 0, 1);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-300, 300);
  for (Correspondence& c : nonsense)
    c.current.head<2>() += Eigen::Vector2d(uniform(random), uniform(random));
  EXPECT_FALSE(
      solvePose(rig, nonsense, kDriving, DisparityOffset(), 0.3, PoseSolverParams()).found);
}

// The vote and the sums of the refinement are shared out.
TEST(PoseSolver, ThreadsDoNotChangeTheResult) {
  const StereoRig rig = kittiRig();
  auto all = observe(rig, kDriving, 700, 0.3, 1);
  for (size_t i = 0; i < all.size(); i += 3) all[i].current.x() += 20;  // outliers
  const int threads_before = cv::getNumThreads();
  PoseSolution expected;
  for (const int threads : {1, 1, 2, 3, 7}) {
    cv::setNumThreads(threads);
    const auto solution = solvePose(rig, all, Eigen::Isometry3d::Identity(), DisparityOffset(), 0.3,
                                    PoseSolverParams());
    ASSERT_TRUE(solution.found);
    if (!expected.found) expected = solution;
    EXPECT_EQ(solution.T_cam_prev.matrix(), expected.T_cam_prev.matrix()) << threads;
    EXPECT_EQ(solution.covariance, expected.covariance) << threads;
    EXPECT_EQ(solution.inlier, expected.inlier) << threads;
  }
  cv::setNumThreads(threads_before);
}

}  // namespace
}  // namespace predictive_stereo
