/// Faults in the motion model: a wrong expectation must not cause the next wrong one.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <random>

#include "evaluation/sequence.h"
#include "odometry/ego_motion_state.h"
#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {
namespace {

constexpr double kDegree = 3.14159265358979 / 180;

// An error of 5 degrees and 0.3 m, in a random direction.
Eigen::Isometry3d fault(int seed) {
  std::mt19937 random(static_cast<unsigned>(seed));
  std::normal_distribution<double> normal;
  const auto direction = [&] {
    const double x = normal(random), y = normal(random), z = normal(random);
    return Eigen::Vector3d(x, y, z).normalized();
  };
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(5 * kDegree, direction()).toRotationMatrix();
  T.translation() = 0.3 * direction();
  return T;
}

struct Differences {
  int lost = 0;
  double largest_m = 0;  ///< beyond 1 % of the way
  double largest_rad = 0;
};

// The expectation is wrong in frame 4 and in frames 8 to 17. Compares with an ego-motion without
// faults: in frames after a fault (`after`), and in those with one (`within`).
void inject(const Sequence& sequence, int first, int frames, int seed, Differences& after,
            Differences& within) {
  EgoMotion undisturbed{EgoMotionParams()};
  EgoMotionState disturbed{EgoMotionParams()};
  for (int k = 0; k < frames; ++k) {
    const SequenceFrame frame = sequence.frame(first + k);
    const auto expected = undisturbed.estimate(frame.left, frame.right, sequence.rig());
    const bool faulty = k == 4 || (k >= 8 && k < 18);
    if (faulty)
      disturbed.usual.T_cam_prev = compose(fault(100 * seed + k), disturbed.usual.T_cam_prev);
    const auto found = disturbed.estimate(frame.left, frame.right, sequence.rig(), {}, {}, 0.1);
    if (k == 0) continue;
    Differences& differences = faulty ? within : after;
    differences.lost += found.state != PoseState::kKnown;
    const Eigen::Isometry3d off = relative(expected.motion.T_cam_prev, found.motion.T_cam_prev);
    const double way_m = expected.motion.T_cam_prev.translation().norm();
    differences.largest_m =
        std::max(differences.largest_m, off.translation().norm() - 0.01 * way_m);
    differences.largest_rad =
        std::max(differences.largest_rad, Eigen::AngleAxisd(off.linear()).angle());
  }
}

void expectRightAgain(const Sequence& sequence, int first) {
  for (const int seed : {1, 2}) {
    SCOPED_TRACE(sequence.name() + ", faults " + std::to_string(seed));
    Differences after, within;
    inject(sequence, first, 22, seed, after, within);
    EXPECT_EQ(after.lost + within.lost, 0);
    EXPECT_LT(after.largest_m, 0.002);
    EXPECT_LT(after.largest_rad, 0.03 * kDegree);
    EXPECT_LT(within.largest_m, 0.02);
    EXPECT_LT(within.largest_rad, 0.1 * kDegree);
  }
}

TEST(WrongExpectation, KittiDrives) {
  const char* kitti = std::getenv("KITTI_EXCERPTS");
  if (!kitti) GTEST_SKIP() << "KITTI_EXCERPTS is not set";
  expectRightAgain(
      *kittiDriveSequence(std::string(kitti) + "/2011_09_26", "2011_09_26_drive_0009_sync"), 0);
  expectRightAgain(
      *kittiDriveSequence(std::string(kitti) + "/2011_09_30", "2011_09_30_drive_0020_sync"), 0);
}

TEST(WrongExpectation, EurocOnTheFloor) {
  const char* kitti = std::getenv("KITTI_EXCERPTS");
  const std::string day = std::string(kitti ? kitti : "") + "/../euroc/2014_06_25";
  if (!kitti || !std::filesystem::is_directory(day))
    GTEST_SKIP() << "no folder euroc beside that which KITTI_EXCERPTS names";
  expectRightAgain(*kittiDriveSequence(day, "V1_01_easy_head_sync"), 0);
}

TEST(WrongExpectation, Streets) {
  for (const char* scene : {"street", "fast_rotation", "standstill"}) {
    StreetParams params;
    params.scene = scene;
    params.seed = 3;
    params.width = 828;
    params.height = 250;
    expectRightAgain(*streetSequence(params), 10);
  }
}

}  // namespace
}  // namespace predictive_stereo
