#include "predictive_stereo/stereo_rig.h"

#include <gtest/gtest.h>

#include "predictive_stereo/disparity_motion.h"

namespace predictive_stereo {
namespace {

Matrix34d projection(double focal_px, double cx_px, double cy_px, double offset_px_m) {
  Matrix34d P;
  P << focal_px, 0, cx_px, offset_px_m, 0, focal_px, cy_px, 0, 0, 0, 1, 0;
  return P;
}

StereoRig kittiColour() {
  return StereoRig::fromProjections(projection(721.5, 609.5, 172.8, 44.857),
                                    projection(721.5, 609.5, 172.8, -339.524), {1242, 375});
}

TEST(StereoRig, BaselineUsesBothCameras) { EXPECT_NEAR(kittiColour().baseline_m, 0.5327, 1e-4); }

TEST(StereoRig, RefusesSwappedCamerasAndPrintsBothMatrices) {
  try {
    StereoRig::fromProjections(projection(721.5, 609.5, 172.8, -339.524),
                               projection(721.5, 609.5, 172.8, 44.857), {1242, 375});
    FAIL() << "a negative baseline was accepted";
  } catch (const std::invalid_argument& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("baseline -0.53"), std::string::npos) << text;
    EXPECT_NE(text.find("P_left"), std::string::npos);
    EXPECT_NE(text.find("P_right"), std::string::npos);
  }
}

TEST(StereoRig, RefusesUncalibratedCameras) {
  EXPECT_THROW(StereoRig::fromProjections(Matrix34d::Zero(), Matrix34d::Zero(), {640, 480}),
               std::invalid_argument);
  EXPECT_THROW(StereoRig::fromProjections(projection(700, 320, 240, 0),
                                          projection(700, 320, 240, -70), {0, 0}),
               std::invalid_argument);
}

// Found by the fuzz target of the pipeline: the shift between the images did not fit into an int.
TEST(StereoRig, RefusesPrincipalPointsThatNoCameraHas) {
  const auto rig = [](double cx_left_px, double cx_right_px, double cy_px) {
    return StereoRig::fromProjections(projection(700, cx_left_px, cy_px, 0),
                                      projection(700, cx_right_px, cy_px, -70), {640, 480});
  };
  EXPECT_NO_THROW(rig(320, 300, 240));
  for (const double far_px : {1e308, -1e7}) {
    EXPECT_THROW(rig(far_px, 320, 240), std::invalid_argument);
    EXPECT_THROW(rig(320, far_px, 240), std::invalid_argument);
    EXPECT_THROW(rig(320, 320, far_px), std::invalid_argument);
  }
}

TEST(StereoRig, RefusesImagesWhoseRowsDiffer) {
  const auto rig = [](double cy_right_px) {
    return StereoRig::fromProjections(projection(700, 320, 240, 0),
                                      projection(700, 320, cy_right_px, -70), {640, 480});
  };
  EXPECT_NO_THROW(rig(242));
  EXPECT_THROW(rig(232), std::invalid_argument);
}

TEST(StereoRig, RefusesDisparitiesThatAreNotFinite) {
  constexpr double kHuge = 1e308;
  EXPECT_THROW(StereoRig::fromProjections(projection(700, 320, 240, kHuge),
                                          projection(700, 320, 240, -kHuge), {1280, 720}),
               std::invalid_argument);
}

TEST(StereoRig, DisparityAndPointAreInverse) {
  const StereoRig rig = kittiColour();
  const Eigen::Vector3d point_m(1.5, -0.7, 12.0);
  const Eigen::Vector3d omega = rig.disparityFromPoint(point_m);
  EXPECT_TRUE(rig.pointFromDisparity(omega.x(), omega.y(), omega.z()).isApprox(point_m, 1e-12));
}

TEST(DisparityMotion, MovesPointsLikeTheirEuclideanMotion) {
  const StereoRig rig = kittiColour();
  Eigen::Isometry3d T_cam_prev = Eigen::Isometry3d::Identity();
  T_cam_prev.linear() = Eigen::AngleAxisd(0.03, Eigen::Vector3d(1, 2, -1).normalized()).matrix();
  T_cam_prev.translation() << 0.1, -0.05, -1.2;
  const Eigen::Matrix4d H = disparityMotion(rig, T_cam_prev);
  for (const auto& point_m : {Eigen::Vector3d(1, 2, 8), Eigen::Vector3d(-9, -1, 40)}) {
    Eigen::Vector4d moved = H * rig.disparityFromPoint(point_m).homogeneous();
    moved /= moved.w();
    const Eigen::Vector3d expected = rig.disparityFromPoint(T_cam_prev * point_m);
    EXPECT_TRUE(moved.head<3>().isApprox(expected, 1e-9));
  }
}

TEST(DisparityMotion, StandstillIsIdentity) {
  const Eigen::Matrix4d H = disparityMotion(kittiColour(), Eigen::Isometry3d::Identity());
  EXPECT_TRUE((H / H(3, 3)).isApprox(Eigen::Matrix4d::Identity(), 1e-9));
}

}  // namespace
}  // namespace predictive_stereo
