#include "nodelets/transforms.h"

#include <gtest/gtest.h>

#include <cmath>

#include "nodelets/ego_motion_processor.h"
#include "nodelets/tf_input.h"

namespace predictive_stereo {
namespace {

Eigen::Isometry3d pose(double x, double y, double z, const Eigen::Vector3d& turn_rad) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << x, y, z;
  if (turn_rad.norm() > 0)
    T.linear() = Eigen::AngleAxisd(turn_rad.norm(), turn_rad.normalized()).toRotationMatrix();
  return T;
}

geometry_msgs::TransformStamped stamped(const char* parent, const char* child, double stamp_s,
                                        const Eigen::Isometry3d& T) {
  return transformMsg(ros::Time(stamp_s), parent, child, T);
}

// The exponential map as a power series.
Eigen::Isometry3d exponential(const Vector6d& twist, double dt_s) {
  Eigen::Matrix4d generator = Eigen::Matrix4d::Zero();
  generator << 0, -twist(5), twist(4), twist(0), twist(5), 0, -twist(3), twist(1), -twist(4),
      twist(3), 0, twist(2), 0, 0, 0, 0;
  generator *= dt_s;
  Eigen::Matrix4d sum = Eigen::Matrix4d::Identity(), term = sum;
  for (int k = 1; k < 40; ++k) {
    term = term * generator / k;
    sum += term;
  }
  return Eigen::Isometry3d(sum);
}

TEST(Transforms, survive_messages) {
  const Eigen::Isometry3d T = pose(1, -2, 3, {0.3, -0.2, 2.5});
  EXPECT_TRUE(fromMsg(transformMsg({}, "a", "b", T).transform).isApprox(T, 1e-14));
}

TEST(Transforms, a_quaternion_that_is_not_normalised_is_taken) {
  geometry_msgs::Transform message;
  message.rotation.w = message.rotation.z = 10;  // 90 degrees about z
  EXPECT_TRUE((fromMsg(message) * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d::UnitY()));
}

TEST(Transforms, covariances_are_row_major_in_messages) {
  Matrix6d covariance;
  for (int i = 0; i < 36; ++i) covariance(i / 6, i % 6) = i;
  const boost::array<double, 36> message = covarianceMsg(covariance);
  for (int i = 0; i < 36; ++i) EXPECT_EQ(message[i], i);
  EXPECT_EQ(fromMsg(message), covariance);
}

TEST(Transforms, the_adjoint_takes_perturbations_to_another_frame) {
  const Eigen::Isometry3d T_a_b = pose(1, 2, -0.5, {0.4, 0.1, -0.9});
  Vector6d in_b;
  in_b << 0.3, -0.1, 0.2, 0.05, -0.02, 0.07;
  const Eigen::Isometry3d expected = T_a_b * exponential(in_b, 1) * T_a_b.inverse();
  EXPECT_TRUE(exponential(adjoint(T_a_b) * in_b, 1).isApprox(expected, 1e-12));
}

TEST(Transforms, a_constant_twist_makes_the_motion_it_was_taken_from) {
  for (const double turn : {0.0, 1e-9, 5e-4, 0.1, 3.0}) {
    const Eigen::Isometry3d motion =
        pose(0.5, -0.1, 0.02, Eigen::Vector3d(0.2, -0.3, 1).normalized() * turn);
    const Vector6d twist = constantTwist(motion, 0.1);
    EXPECT_TRUE(exponential(twist, 0.1).isApprox(motion, 1e-9)) << "turn by " << turn;
  }
}

TEST(Transforms, tf_answers_at_the_stamp_or_says_why_not) {
  tf2::BufferCore tf;
  const Eigen::Isometry3d early = pose(0, 0, 0, {0, 0, 0}), late = pose(2, 0, 0, {0, 0, 0.2});
  tf.setTransform(stamped("odom", "camera", 10.0, early), "test");
  tf.setTransform(stamped("odom", "camera", 10.2, late), "test");
  std::string error;
  const auto middle = lookUpTransform(tf, "odom", "camera", ros::Time(10.1), error);
  ASSERT_TRUE(middle);
  EXPECT_TRUE(middle->isApprox(pose(1, 0, 0, {0, 0, 0.1}), 1e-6));
  EXPECT_FALSE(lookUpTransform(tf, "odom", "camera", ros::Time(10.3), error)) << "no extrapolation";
  EXPECT_NE(error.find("extrapolation"), std::string::npos) << error;
  EXPECT_FALSE(lookUpTransform(tf, "odom", "elsewhere", ros::Time(10.1), error));
  EXPECT_NE(error.find("elsewhere"), std::string::npos) << error;
}

TEST(Transforms, slashes_at_the_beginning_of_frames_do_not_count) {
  tf2::BufferCore tf;
  tf.setTransform(stamped("/odom", "/camera", 10.0, pose(0, 0, 0, {0, 0, 0})), "test");
  tf.setTransform(stamped("/odom", "/camera", 10.2, pose(2, 0, 0, {0, 0, 0.2})), "test");
  std::string error;
  const ros::Time before(10), now(10.2);
  EXPECT_TRUE(lookUpTransform(tf, "/odom", "/camera", now, error)) << error;
  EXPECT_TRUE(lookUpCameraMotion(tf, "/camera", before, now, "/odom", error)) << error;
  EXPECT_EQ(newestPose(tf, "/odom", "/camera"), now);

  EgoMotionNodeletParams params;
  params.base_frame = "head";
  StereoPair pair;
  const auto left = boost::make_shared<sensor_msgs::Image>();
  left->header.frame_id = "/head";
  pair.left = left;
  EXPECT_TRUE(EgoMotionProcessor(params).extrinsic(tf, pair, error)) << "it is its own base";
}

TEST(Transforms, a_camera_that_looks_up_may_not_have_its_optical_frame) {
  const auto doubt = [](const Eigen::Vector3d& turn_rad) {
    return doubtAboutMount(pose(0, 0, 1, turn_rad), "base", "camera_link");
  };
  EXPECT_NE(doubt({0, 0, 0}).find("camera_link"), std::string::npos);
  EXPECT_NE(doubt({0, 0.4, 1}), "") << "camera_link of a camera that looks down a little";
  EXPECT_EQ(doubt(Eigen::Vector3d(-1, 1, -1) * 2 * M_PI / std::sqrt(27)), "") << "ahead";
  EXPECT_EQ(doubt({M_PI, 0, 0}), "") << "down";
  EXPECT_NE(doubt(Eigen::Vector3d(1, 1, 1) * 2 * M_PI / std::sqrt(27)).find("upside down"),
            std::string::npos)
      << "ahead, y up";
  EXPECT_EQ(doubtAboutMount(Eigen::Isometry3d::Identity(), "head", "/head"), "") << "its own base";
}

TEST(Transforms, what_tf_answers_does_not_depend_on_other_poses_in_its_buffer) {
  const Eigen::Isometry3d now = pose(1.23456789, -0.3, 7, {0.01, 0.2, -0.4});
  tf2::BufferCore alone, among_others;
  alone.setTransform(stamped("odom", "camera", 10.0, now), "test");
  for (int i = -3; i <= 3; ++i)
    among_others.setTransform(stamped("odom", "camera", 10.0 + 0.1 * i,
                                      i == 0 ? now : pose(0.1 * i, i, 1, {0.1 * i, 0, 0.02 * i})),
                              "test");
  std::string error;
  const auto a = lookUpTransform(alone, "odom", "camera", ros::Time(10), error);
  const auto b = lookUpTransform(among_others, "odom", "camera", ros::Time(10), error);
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->matrix(), b->matrix()) << "bit by bit";
}

TEST(Transforms, the_cameras_motion_is_the_past_in_the_presents_frame) {
  tf2::BufferCore tf;
  const Eigen::Isometry3d before = pose(1, 2, 0, {0, 0, 0.3}),
                          now = pose(1.5, 2.2, 0.1, {0, 0.1, 0.4});
  tf.setTransform(stamped("odom", "base", 10.0, before), "test");
  tf.setTransform(stamped("odom", "base", 10.1, now), "test");
  const Eigen::Isometry3d mount = pose(0.3, 0, 1.2, {-1.2, 1.2, -1.2});
  tf.setTransform(stamped("base", "camera", 0, mount), "test", true);
  std::string error;
  const auto T_cam_prev =
      lookUpCameraMotion(tf, "camera", ros::Time(10.0), ros::Time(10.1), "odom", error);
  ASSERT_TRUE(T_cam_prev) << error;
  EXPECT_TRUE(T_cam_prev->isApprox((now * mount).inverse() * (before * mount), 1e-8));
  EXPECT_FALSE(lookUpCameraMotion(tf, "camera", ros::Time(10.0), ros::Time(10.2), "odom", error));
}

TEST(Transforms, an_odometry_that_knows_nothing_is_recognised) {
  nav_msgs::Odometry odometry;
  EXPECT_FALSE(twistIsUnknown(odometry));
  odometry.twist.covariance = covarianceMsg(kUnknownCovariance * Matrix6d::Identity());
  EXPECT_TRUE(twistIsUnknown(odometry));
  // Wheel odometry measures only some axes; this does not mean that it is lost.
  odometry.twist.covariance[0] = 0.01;
  EXPECT_FALSE(twistIsUnknown(odometry));
}

TEST(Transforms, a_motions_covariance_is_that_of_the_twist_in_the_cameras_frame) {
  nav_msgs::Odometry odometry;
  const Vector6d variances = (Vector6d() << 0.04, 0.01, 0.02, 1e-4, 2e-4, 3e-4).finished();
  odometry.twist.covariance = covarianceMsg(variances.asDiagonal());
  // The camera's optical axis is the child's x axis: its z is the child's x, its x the child's -y.
  Eigen::Isometry3d T_cam_child = Eigen::Isometry3d::Identity();
  T_cam_child.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  const Matrix6d covariance = motionCovariance(odometry, 0.1, T_cam_child);
  const Vector6d expected = (Vector6d() << 0.01, 0.02, 0.04, 2e-4, 3e-4, 1e-4).finished() * 0.01;
  EXPECT_TRUE(covariance.isApprox(Matrix6d(expected.asDiagonal()), 1e-12)) << covariance;
}

TEST(Transforms, a_covariance_without_a_meaning_is_unknown) {
  nav_msgs::Odometry odometry;
  Matrix6d covariance = 0.01 * Matrix6d::Identity();
  for (const double value : {-1.0, std::nan("")}) {
    covariance(1, 1) = value;
    odometry.twist.covariance = covarianceMsg(covariance);
    EXPECT_EQ(motionCovariance(odometry, 0.1, Eigen::Isometry3d::Identity()), Matrix6d::Zero())
        << value;
  }
}

// Drivers of wheels give huge variances, or zeros, to what wheels do not measure.
TEST(Transforms, axes_whose_variance_is_not_told_get_the_default) {
  nav_msgs::Odometry odometry;
  const Matrix6d untold = untoldCovariance();
  for (const double value : {0.0, kUnknownCovariance, 1e6}) {
    Matrix6d covariance = value * Matrix6d::Identity();
    for (const int axis : {0, 1, 5}) covariance(axis, axis) = 0.01;
    covariance(0, 5) = covariance(5, 0) = 0.002;
    covariance(0, 4) = covariance(4, 0) = 0.001;
    odometry.twist.covariance = covarianceMsg(covariance);
    const Matrix6d motion = motionCovariance(odometry, 0.1, Eigen::Isometry3d::Identity());
    for (const int axis : {0, 1, 5}) EXPECT_NEAR(motion(axis, axis), 1e-4, 1e-12);
    for (const int axis : {2, 3, 4}) EXPECT_NEAR(motion(axis, axis), untold(axis, axis), 1e-12);
    EXPECT_NEAR(motion(0, 5), 2e-5, 1e-12);
    EXPECT_EQ(motion(0, 4), 0);
  }
  for (const double value :
       {0.0, kUnknownCovariance}) {  // of all axes: MovingObjects has a default
    odometry.twist.covariance = covarianceMsg(value * Matrix6d::Identity());
    EXPECT_TRUE(motionCovariance(odometry, 0.1, Eigen::Isometry3d::Identity()).isZero());
  }
}

}  // namespace
}  // namespace predictive_stereo
