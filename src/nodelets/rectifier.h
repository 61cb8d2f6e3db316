#pragma once

#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/distortion_models.h>

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>

#include "nodelets/message_pool.h"
#include "nodelets/stereo_messages.h"

namespace predictive_stereo {

/// Rectifies the images of one camera by its calibration: distortion D and matrix K of the real
/// camera, rotation R and projection P of the rectified one.
class Rectifier {
 public:
  /// @param raw  in any encoding that greyImage accepts; cropped and binned as `info` says.
  /// @returns mono8 with the same size, stamp and frame; pixels outside the camera's view are
  ///   black.
  /// @throws std::invalid_argument for an image or a calibration that cannot be used.
  sensor_msgs::ImagePtr rectify(const sensor_msgs::Image& raw,
                                const sensor_msgs::CameraInfo& info) {
    const cv::Mat1b grey = greyImage(raw, "raw");
    try {
      calibrate(info, grey.size());
    } catch (const cv::Exception& error) {  // e.g. for an unsupported number of coefficients
      info_ = sensor_msgs::CameraInfo();
      throw std::invalid_argument("camera_info cannot be used; calibrate the camera again: " +
                                  error.msg);
    }
    sensor_msgs::ImagePtr rectified = images_.take();
    cv::remap(grey, allocateImage<uint8_t>(raw.header, grey.size(), *rectified), map_, fractions_,
              cv::INTER_LINEAR, cv::BORDER_CONSTANT);
    return rectified;
  }

 private:
  void calibrate(const sensor_msgs::CameraInfo& info, cv::Size size) {
    if (sameCalibration(info, info_) && map_.size() == size) return;
    if (!(info.K[0] > 0 && info.K[4] > 0 && info.P[0] > 0 && info.P[5] > 0))
      throw std::invalid_argument(
          "camera_info has no calibration (fx in K is " + std::to_string(info.K[0]) + ", in P " +
          std::to_string(info.P[0]) +
          "): calibrate the camera (camera_calibration's cameracalibrator), or, if its images are "
          "rectified already, do not set rectify");
    const auto isFinite = [](double value) { return std::isfinite(value); };
    if (!std::all_of(info.K.begin(), info.K.end(), isFinite) ||
        !std::all_of(info.D.begin(), info.D.end(), isFinite) ||
        !std::all_of(info.P.begin(), info.P.end(), isFinite))
      throw std::invalid_argument(
          "camera_info: a number in K, D or P is not finite: calibrate the camera again");
    const cv::Matx33d K = intrinsics(info), P = rectifiedIntrinsics(info), R(info.R.data());
    constexpr double kTolerance = 1e-2;  // of a rotation with few decimals
    if (!(cv::norm(R * R.t(), cv::Matx33d::eye(), cv::NORM_INF) <= kTolerance))
      throw std::invalid_argument(
          "camera_info: R, which begins with " + std::to_string(info.R[0]) +
          ", is no rotation: calibrate the cameras again (1 0 0 0 1 0 0 0 1 turns nothing)");
    namespace models = sensor_msgs::distortion_models;
    cv::Mat1f x, y;
    if (info.D.empty() || info.distortion_model == models::PLUMB_BOB ||
        info.distortion_model == models::RATIONAL_POLYNOMIAL)
      cv::initUndistortRectifyMap(K, info.D, R, P, size, CV_32FC1, x, y);
    else if (info.distortion_model == "equidistant" || info.distortion_model == "fisheye")
      cv::fisheye::initUndistortRectifyMap(K, info.D, R, P, size, CV_32FC1, x, y);
    else
      throw std::invalid_argument(
          "camera_info has distortion_model '" + info.distortion_model +
          "': must be plumb_bob, rational_polynomial or equidistant; calibrate with one of these");
    const cv::Mat is_seen = (x >= 0) & (y >= 0) & (x < size.width) & (y < size.height);
    if (cv::countNonZero(is_seen) < 0.01 * size.area())
      throw std::invalid_argument(
          "camera_info: by K, D and R the rectified image shows next to nothing of the raw one: "
          "calibrate the camera again");
    cv::convertMaps(x, y, map_, fractions_, CV_16SC2);
    info_ = info;
  }

  static bool sameCalibration(const sensor_msgs::CameraInfo& a, const sensor_msgs::CameraInfo& b) {
    return a.distortion_model == b.distortion_model && a.D == b.D && a.K == b.K && a.R == b.R &&
           a.P == b.P && a.roi.x_offset == b.roi.x_offset && a.roi.y_offset == b.roi.y_offset &&
           a.binning_x == b.binning_x && a.binning_y == b.binning_y;
  }

  static cv::Matx33d intrinsics(const sensor_msgs::CameraInfo& info) {
    cv::Matx33d K(info.K.data());
    K(0, 2) -= info.roi.x_offset;
    K(1, 2) -= info.roi.y_offset;
    const double scale_x = 1.0 / std::max(1u, info.binning_x);
    const double scale_y = 1.0 / std::max(1u, info.binning_y);
    return cv::Matx33d(scale_x, 0, 0, 0, scale_y, 0, 0, 0, 1) * K;
  }

  static cv::Matx33d rectifiedIntrinsics(const sensor_msgs::CameraInfo& info) {
    const Matrix34d P = projectionMatrix(info);
    return cv::Matx33d(P(0, 0), P(0, 1), P(0, 2), P(1, 0), P(1, 1), P(1, 2), 0, 0, 1);
  }

  sensor_msgs::CameraInfo info_;  // from which the maps were made
  cv::Mat map_, fractions_;       // for cv::remap
  MessagePool<sensor_msgs::Image> images_;
};

}  // namespace predictive_stereo
