/// Calibration of a rectified stereo camera.
#pragma once

#include <Eigen/Core>
#include <opencv2/core/types.hpp>

namespace predictive_stereo {

using Matrix34d = Eigen::Matrix<double, 3, 4>;

/// A rectified stereo rig: two pinhole cameras with parallel axes, the right one displaced along x.
///
/// Disparity here is d = x_left - x_right - (cx_left - cx_right), so that depth Z = fx * baseline /
/// d also where the two principal points differ.
struct StereoRig {
  cv::Size size;           ///< image size [px]
  double fx_px = 0;        ///< focal length in x [px]
  double fy_px = 0;        ///< focal length in y [px]
  double cx_left_px = 0;   ///< principal point of the left image, column [px]
  double cx_right_px = 0;  ///< principal point of the right image, column [px]
  double cy_px = 0;        ///< principal point of both images, row [px]
  double baseline_m = 0;   ///< distance of the optical centres [m], positive

  /// Builds the rig from the 3x4 projection matrices of two rectified cameras (CameraInfo.P,
  /// KITTI's P_rect). baseline = (P_left(0,3) - P_right(0,3)) / fx: both cameras may have an
  /// offset, as KITTI's colour pair does.
  /// @param size  of the images [px].
  /// @throws std::invalid_argument if the size is empty; if an entry of P is not finite; if a focal
  ///   length is not positive, or differs by more than 0.1 %; if a principal point is more than
  ///   10^6 px away, or their rows differ by more than 3 px; if the baseline is not positive
  ///   (swapped cameras); or if fx * baseline is not finite. The message has both P.
  static StereoRig fromProjections(const Matrix34d& P_left, const Matrix34d& P_right,
                                   cv::Size size);

  /// cx_left - cx_right [px]: x_left - x_right of points at infinity, whose disparity is 0.
  double principalOffset() const { return cx_left_px - cx_right_px; }

  /// fx * baseline [px m]: disparity times depth.
  double disparityTimesDepth() const { return fx_px * baseline_m; }

  /// The point [m] in the left camera's optical frame that is at (x, y) [px] in the left image.
  /// @param disparity_px  positive; this is not checked.
  Eigen::Vector3d pointFromDisparity(double x_px, double y_px, double disparity_px) const;

  /// (x, y, d) [px] in disparity space of a point [m] in the left camera's optical frame.
  /// @param point_cam_m  with Z > 0; this is not checked.
  Eigen::Vector3d disparityFromPoint(const Eigen::Vector3d& point_cam_m) const;

  bool operator==(const StereoRig& other) const;
  bool operator!=(const StereoRig& other) const { return !(*this == other); }
};

}  // namespace predictive_stereo
