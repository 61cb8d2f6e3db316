/// With images worse than the recorded ones the path is the same, and no frame is lost.
#include <gtest/gtest.h>

#include <cstdlib>
#include <functional>

#include "evaluation/sequence.h"
#include "predictive_stereo/ego_motion.h"
#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {
namespace {

struct Perturbation {
  std::string name;
  int step = 1;  ///< only every n-th frame is used
  std::function<void(int frame, cv::Mat1b& image)> spoil;
};

void addNoise(cv::Mat1b& image, cv::RNG& random) {
  cv::Mat1s noise(image.size());
  random.fill(noise, cv::RNG::NORMAL, 0, 5);
  cv::add(image, noise, image, cv::noArray(), CV_8U);
}

std::vector<Perturbation> perturbations() {
  auto random = std::make_shared<cv::RNG>(1);
  return {
      {"every second frame", 2, {}},
      {"every third frame", 3, {}},
      {"noise of 5 grey levels", 1, [random](int, cv::Mat1b& image) { addNoise(image, *random); }},
      {"alternating brightness", 1,
       [](int frame, cv::Mat1b& image) { image *= frame % 2 ? 1.25 : 0.8; }},
      {"15 % of the brightness", 1, [](int, cv::Mat1b& image) { image *= 0.15; }},
  };
}

/// Positions of the used frames relative to the first one. Adds the number of lost frames to
/// `lost`.
std::vector<Eigen::Vector3d> positions(const Sequence& sequence, const Perturbation& perturbation,
                                       int& lost) {
  EgoMotion ego_motion{EgoMotionParams()};
  Eigen::Isometry3d T_first_cam = Eigen::Isometry3d::Identity();
  std::vector<Eigen::Vector3d> positions;
  for (int k = 0; k < sequence.frames(); k += perturbation.step) {
    SequenceFrame frame = sequence.frame(k);
    if (perturbation.spoil) {
      perturbation.spoil(k, frame.left);
      perturbation.spoil(k, frame.right);
    }
    const auto estimate = ego_motion.estimate(frame.left, frame.right, sequence.rig());
    lost += k > 0 && estimate.state != PoseState::kKnown;
    T_first_cam = compose(T_first_cam, estimate.motion.T_cam_prev.inverse());
    positions.push_back(T_first_cam.translation());
  }
  return positions;
}

/// Length of the path through every step-th position.
double pathLength(const std::vector<Eigen::Vector3d>& positions, int step) {
  double way_m = 0;
  const auto n = static_cast<size_t>(step);
  for (size_t i = n; i < positions.size(); i += n)
    way_m += (positions[i] - positions[i - n]).norm();
  return way_m;
}

class PerturbedInputs : public testing::TestWithParam<const char*> {};

TEST_P(PerturbedInputs, LeaveTheWayAsItIs) {
  const char* kitti = std::getenv("KITTI_EXCERPTS");
  if (!kitti) GTEST_SKIP() << "KITTI_EXCERPTS is not set";
  const std::string day = std::string(GetParam()).substr(0, 10);
  const auto sequence = kittiDriveSequence(std::string(kitti) + "/" + day, GetParam());
  int lost = 0;
  const auto undisturbed = positions(*sequence, {}, lost);
  EXPECT_EQ(lost, 0);
  for (const Perturbation& perturbation : perturbations()) {
    lost = 0;
    const double way_m = pathLength(positions(*sequence, perturbation, lost), 1);
    const double expected_m = pathLength(undisturbed, perturbation.step);
    std::printf("%s, %s: %.2f m, %+.2f %% of the undisturbed way, %d lost\n", GetParam(),
                perturbation.name.c_str(), way_m, 100 * (way_m / expected_m - 1), lost);
    EXPECT_EQ(lost, 0) << perturbation.name;
    EXPECT_NEAR(way_m / expected_m, 1, 0.006) << perturbation.name;
  }
}

INSTANTIATE_TEST_SUITE_P(KittiDrives, PerturbedInputs,
                         testing::Values("2011_09_26_drive_0001_sync", "2011_09_26_drive_0009_sync",
                                         "2011_09_30_drive_0020_sync"),
                         [](const auto& info) { return std::string(info.param).substr(11, 10); });

}  // namespace
}  // namespace predictive_stereo
