/// Features of the current stereo pair: those of a reference frame, followed, and new corners.
#pragma once

#include <optional>
#include <vector>

#include "imaging/image_pyramid.h"
#include "odometry/features.h"
#include "odometry/pose_solver.h"
#include "odometry/reference_frame.h"
#include "odometry/stereo_depth.h"
#include "predictive_stereo/ego_motion.h"

namespace predictive_stereo {

/// Row alignment of the features, with its memory of past frames.
struct FeatureRows {
  RowOffsetFilter filter;
  RowOffsetModel model;
};

/// Features of a reference frame in the current stereo pair.
struct FollowedFeatures {
  int searched = 0;                             ///< all but those on the mask
  std::vector<Correspondence> correspondences;  ///< those that are found in both images
  std::optional<FeatureRows> rows;              ///< fitted to these features too
};

/// Finds features in stereo pairs, with their disparities. Fits the row alignment to them.
class StereoFeatures {
 public:
  /// @param params  within their limits.
  explicit StereoFeatures(const EgoMotionParams& params);
  void setParams(const EgoMotionParams& params);
  /// Forgets the row alignment.
  void reset();

  /// Sets the current stereo pair. Does not copy the right image: it must stay unchanged while the
  /// pair is in use.
  void setPair(const cv::Mat1b& left, const cv::Mat1b& right, const StereoRig& rig);
  const StereoRig& rig() const { return rig_; }
  const RowOffsetModel& rowAlignment() const { return rows_.model; }

  /// Finds the features of a reference in the current pair. Changes nothing: several motions may be
  /// tried, and keepRows() then takes the row alignment of the chosen one.
  /// @param T_expected  the motion since the reference.
  /// @param ignored_mask  empty, or not 0 where features of the reference are ignored.
  FollowedFeatures follow(const ReferenceFrame& reference, const Eigen::Isometry3d& T_expected,
                          const cv::Mat1b& ignored_mask) const;
  void keepRows(const FeatureRows& rows) { rows_ = rows; }

  /// Whether far more corners match with negative disparities than with positive ones.
  bool lookSwapped();

  /// Makes the current pair a reference, without a disparity offset: keeps the points of
  /// `correspondences`, and adds new corners between them. Moves the left image, so the pair cannot
  /// be used any more.
  /// @param inlier  for each correspondence, whether it agrees with the motion of the camera.
  ReferenceFrame makeReference(const std::vector<Correspondence>& correspondences,
                               const std::vector<char>& inlier);

 private:
  std::vector<StereoMatch> findCorners(const std::vector<cv::Point2f>& taken);
  StereoSearch stereoSearch() const;
  void findInRightImage(std::vector<StereoMatch>& matches) const;
  void updateRows(const std::vector<StereoMatch>& matches, FeatureRows& rows) const;
  float disparity(const StereoMatch& match, const RowOffsetModel& alignment) const;

  EgoMotionParams params_;
  StereoRig rig_;
  ImagePyramid left_, right_;
  FeatureRows rows_;
  CornerDetector detector_;
};

}  // namespace predictive_stereo
