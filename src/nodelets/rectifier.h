#pragma once

#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>

#include <opencv2/core.hpp>

#include "nodelets/message_pool.h"

namespace predictive_stereo {

/// Rectifies the images of one camera by its calibration: distortion D and matrix K of the real
/// camera, rotation R and projection P of the rectified one.
class Rectifier {
 public:
  /// @param raw  in any encoding that greyImage accepts; cropped and binned as `info` says.
  /// @returns mono8 with the same size, stamp and frame; pixels outside the camera's view are
  ///   black.
  /// @throws std::invalid_argument for an image or a calibration that cannot be used.
  sensor_msgs::ImagePtr rectify(const sensor_msgs::Image& raw, const sensor_msgs::CameraInfo& info);

 private:
  void calibrate(const sensor_msgs::CameraInfo& info, cv::Size size);

  sensor_msgs::CameraInfo info_;  // from which the maps were made
  cv::Mat map_, fractions_;       // for cv::remap
  cv::Mat1b grey_buffer_;
  MessagePool<sensor_msgs::Image> images_;
};

}  // namespace predictive_stereo
