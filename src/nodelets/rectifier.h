#pragma once

#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>

#include <opencv2/core.hpp>

#include "nodelets/message_pool.h"

namespace predictive_stereo {

/// Rectifies one camera's images by its calibration: distortion D and matrix K of the camera as it
/// is, rotation R and projection P of the camera as it should be.
class Rectifier {
 public:
  /// @param raw  any encoding that greyImage takes; cropped and binned as `info` says.
  /// @returns mono8 of the same size, stamp and frame; black where the camera did not see.
  /// @throws std::invalid_argument for an image or a calibration that cannot be used.
  sensor_msgs::ImagePtr rectify(const sensor_msgs::Image& raw, const sensor_msgs::CameraInfo& info);

 private:
  void calibrate(const sensor_msgs::CameraInfo& info, cv::Size size);

  sensor_msgs::CameraInfo info_;  // that the maps are made of
  cv::Mat map_, fractions_;       // as cv::remap takes them
  cv::Mat1b grey_buffer_;
  MessagePool<sensor_msgs::Image> images_;
};

}  // namespace predictive_stereo
