/// A standing camera that trembles: the whole pipeline must report that it stands.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <random>
#include <string>

#include "evaluation/sequence.h"
#include "predictive_stereo/pipeline.h"
#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {
namespace {

constexpr double kDegree = 3.14159265358979 / 180;

struct Pair {
  cv::Mat1b left, right;
};

/// Repeats one pair, with a common shake of both cameras and independent noise.
class Tremble {
 public:
  explicit Tremble(const Pair& pair) : pair_(pair) {}

  Pair next() {
    std::normal_distribution<double> tremble_px(0, 0.3);
    const cv::Matx23d shift(1, 0, tremble_px(random_), 0, 1, tremble_px(random_));
    return {seen(pair_.left, shift), seen(pair_.right, shift)};
  }

 private:
  cv::Mat1b seen(const cv::Mat1b& image, const cv::Matx23d& shift) {
    cv::Mat1b shifted;
    cv::warpAffine(image, shifted, shift, image.size(), cv::INTER_CUBIC, cv::BORDER_REPLICATE);
    cv::Mat1s noise(image.size());
    noise_.fill(noise, cv::RNG::NORMAL, 0, 1.5);
    cv::add(shifted, noise, shifted, cv::noArray(), CV_8U);
    return shifted;
  }

  Pair pair_;
  std::mt19937 random_{1};
  cv::RNG noise_{1};
};

/// Drift of the pipeline's pose from its start.
struct Drift {
  double largest_m = 0, largest_rad = 0, largest_step_m = 0, path_m = 0;
  int lost = 0, boxes = 0;
  double largest_sigmas = 0;  ///< drift relative to its standard deviation in the path's covariance

  void add(const PipelineOutput& output) {
    const Eigen::Isometry3d& T = output.pose.T_odom_cam;
    if (output.motion_start) {
      const double variance_m2 = output.pose.covariance.topLeftCorner<3, 3>().trace();
      largest_sigmas = std::max(largest_sigmas, T.translation().norm() / std::sqrt(variance_m2));
    }
    const double step_m = relative(last_, T).translation().norm();
    last_ = T;
    largest_m = std::max(largest_m, T.translation().norm());
    largest_rad = std::max(largest_rad, Eigen::AngleAxisd(T.linear()).angle());
    largest_step_m = std::max(largest_step_m, step_m);
    path_m += step_m;
    lost += output.pose.state != PoseState::kKnown;
    boxes += static_cast<int>(output.detections.objects.size());
  }

 private:
  Eigen::Isometry3d last_ = Eigen::Isometry3d::Identity();
};

Drift driftOf(const StereoRig& rig, const Pair& pair) {
  const char* frames = std::getenv("STANDING_FRAMES");
  Tremble tremble(pair);
  Pipeline pipeline{PipelineParams()};
  PipelineOutput output;
  Drift drift;
  for (int k = 0; k < (frames ? std::atoi(frames) : 300); ++k) {
    const Pair seen = tremble.next();
    pipeline.process({seen.left, seen.right, rig, k * std::chrono::milliseconds(100)}, output);
    drift.add(output);
  }
  return drift;
}

void expectToStand(const Drift& drift) {
  std::printf("drift %.4f m (%.1f sigma), %.4f deg, largest step %.4f m, path %.3f m\n",
              drift.largest_m, drift.largest_sigmas, drift.largest_rad / kDegree,
              drift.largest_step_m, drift.path_m);
  EXPECT_EQ(drift.lost, 0);
  EXPECT_EQ(drift.boxes, 0);
  EXPECT_LT(drift.largest_m, 0.05);
  EXPECT_LT(drift.largest_rad, 0.5 * kDegree);
  EXPECT_LT(drift.largest_step_m, 0.01);
}

// Use STANDING_FRAMES=3000 for a long test.
TEST(StandingCamera, TremblesBeforeRealPixels) {
  const char* kitti = std::getenv("KITTI_EXCERPTS");
  if (!kitti) GTEST_SKIP() << "KITTI_EXCERPTS is not set";
  const auto sequence =
      kittiDriveSequence(std::string(kitti) + "/2011_09_26", "2011_09_26_drive_0009_sync");
  const SequenceFrame frame = sequence->frame(20);
  expectToStand(driftOf(sequence->rig(), {frame.left, frame.right}));
}

TEST(StandingCamera, TremblesBeforeAStreet) {
  StreetParams params;
  params.scene = "static";
  params.width = 828;
  params.height = 250;
  const Street street(params);
  const StreetFrame frame = street.render(20);
  expectToStand(driftOf(street.rig(), {frame.left, frame.right}));
}

// A drone standing on the floor.
TEST(StandingCamera, EurocOnTheFloor) {
  const char* kitti = std::getenv("KITTI_EXCERPTS");
  const std::string day = std::string(kitti ? kitti : "") + "/../euroc/2014_06_25";
  if (!kitti || !std::filesystem::is_directory(day))
    GTEST_SKIP() << "no folder euroc beside that which KITTI_EXCERPTS names";
  const auto sequence = kittiDriveSequence(day, "V1_01_easy_head_sync");
  ASSERT_EQ(sequence->frames(), 60);
  Pipeline pipeline{PipelineParams()};
  PipelineOutput output;
  Drift drift;
  for (int k = 0; k < sequence->frames(); ++k) {
    const SequenceFrame frame = sequence->frame(k);
    pipeline.process(stereoFrame(*sequence, k, frame), output);
    drift.add(output);
  }
  expectToStand(drift);
  EXPECT_LT(drift.path_m, 0.05);
  // Only here: shifted images, as above, are not those of any camera motion, so their errors are
  // not noise.
  EXPECT_LT(drift.largest_sigmas, 3);
}

}  // namespace
}  // namespace predictive_stereo
