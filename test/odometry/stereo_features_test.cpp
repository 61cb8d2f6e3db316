#include "odometry/stereo_features.h"

#include <gtest/gtest.h>

#include "evaluation/simulation/street.h"

namespace predictive_stereo {
namespace {

TEST(StereoFeatures, TryingAMotionChangesNothing) {
  StreetParams params;
  params.scene = "misaligned";
  params.width = 496;
  params.height = 160;
  const Street street(params);
  const StreetFrame before = street.render(10), now = street.render(11);
  StereoFeatures features{EgoMotionParams()};
  features.setPair(before.left, before.right, street.rig());
  const ReferenceFrame reference = features.makeReference({}, {});
  features.setPair(now.left, now.right, street.rig());

  const RowOffsetModel rows = features.rowAlignment();
  ASSERT_GT(rows.samples, 0);
  const Eigen::Isometry3d rest = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d wrong = rest;
  wrong.rotate(Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitY()));
  const FollowedFeatures first = features.follow(reference, rest, {});
  features.follow(reference, wrong, {});
  EXPECT_EQ(features.rowAlignment().samples, rows.samples);
  EXPECT_EQ(features.rowAlignment().coefficients_px, rows.coefficients_px);

  const FollowedFeatures again = features.follow(reference, rest, {});
  ASSERT_EQ(again.correspondences.size(), first.correspondences.size());
  ASSERT_FALSE(first.correspondences.empty());
  for (size_t i = 0; i < first.correspondences.size(); ++i)
    EXPECT_EQ(again.correspondences[i].current, first.correspondences[i].current) << i;

  ASSERT_TRUE(first.rows);
  features.keepRows(*first.rows);
  EXPECT_GT(features.rowAlignment().samples, rows.samples);
}

}  // namespace
}  // namespace predictive_stereo
