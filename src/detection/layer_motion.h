/// Slow motion, told from the disparities of several past frames alone.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "detection/frame_comparison.h"
#include "detection/frame_history.h"
#include "predictive_stereo/disparity_range.h"

namespace predictive_stereo {

/// A constant velocity of a group of points on level ground.
struct LayerMotion {
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();  ///< over ground, in the camera's axes
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();    ///< of it [m^2/s^2]
  double cost = 0;   ///< see DisparityHistory; mean over points and past frames
  double gain = 0;   ///< by how much it is below that of the static world, where both are known
  double known = 0;  ///< share of points and frames where both are known
};

/// What the disparities of past frames say of points of the current frame and their motion. The
/// cost of a point in a past frame is the squared error of its disparity there in standard
/// deviations, kMostCost where that is larger or one sees through it. It is not known where the
/// point was hidden or out of sight. A static point that what moves would itself have hidden is
/// none: there its cost is kMostCost.
class DisparityHistory {
 public:
  static constexpr float kMostCost = 9;

  /// @param past  frames of the past, the last first; they have to outlive this, as has
  ///   `disparity_px`, that of the current frame.
  DisparityHistory(const StereoRig& rig, const DisparityRange& range, const cv::Mat1f& disparity_px,
                   const std::vector<PastFrame>& past);

  /// The velocity over ground that explains all past frames best, among all that road users have
  /// or, where it is given, near `expected_mps`. None without past frames.
  /// @param points_px  of the current frame, with valid disparities.
  std::optional<LayerMotion> fit(const std::vector<cv::Point>& points_px,
                                 const std::optional<Eigen::Vector3d>& expected_mps = {}) const;

  /// Adds to `sum`, of the lattice points of `area`, by how much the velocity explains the past
  /// better than the static world does: the mean difference of costs, times `weight`; unknown ones
  /// count as 0.
  void addGain(const cv::Rect& area, const Eigen::Vector3d& velocity_mps, float weight,
               cv::Mat1f& sum) const;

 private:
  struct Points;
  SourceOf sourceOf(const PastFrame& past, const Eigen::Vector3d& velocity_mps) const;
  double meanCost(const PastFrame& past, const Eigen::Vector3d& velocity_mps, Points& points) const;

  const StereoRig& rig_;
  const DisparityRange& range_;
  const cv::Mat1f& disparity_px_;
  std::vector<PastFrame> past_;
};

}  // namespace predictive_stereo
