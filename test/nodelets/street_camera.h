#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/image_encodings.h>

#include <boost/make_shared.hpp>
#include <cstring>
#include <string>
#include <vector>

#include "evaluation/simulation/street.h"
#include "nodelets/stereo_messages.h"
#include "nodelets/transforms.h"

namespace predictive_stereo {

inline sensor_msgs::CameraInfoPtr cameraInfo(const StereoRig& rig, ros::Time stamp, bool right) {
  auto message = boost::make_shared<sensor_msgs::CameraInfo>();
  message->header.stamp = stamp;
  message->width = static_cast<uint32_t>(rig.size.width);
  message->height = static_cast<uint32_t>(rig.size.height);
  const double cx = right ? rig.cx_right_px : rig.cx_left_px;
  const double shift = right ? -rig.disparityTimesDepth() : 0.0;
  message->P = {rig.fx_px, 0, cx, shift, 0, rig.fy_px, rig.cy_px, 0, 0, 0, 1, 0};
  return message;
}

/// Messages of a small camera that drives through the synthetic street.
class StreetCamera {
 public:
  static constexpr int kWidth = 416, kHeight = 128;
  static constexpr const char* kFrame = "camera_left_optical_frame";

  explicit StreetCamera(int frames = 6, int seed = 1) : street_(params(frames, seed)) {
    for (int i = 0; i < frames; ++i) frames_.push_back(street_.render(i));
  }

  int frames() const { return static_cast<int>(frames_.size()); }
  const StereoRig& rig() const { return street_.rig(); }
  ros::Time stamp(int index) const {
    return ros::Time(1577836800) + ros::Duration(street_.stampOf(index));
  }

  /// New messages at each call, so that tests can change them.
  StereoPair pair(int index) const {
    StereoPair result;
    result.left = image(frames_[index].left, stamp(index));
    result.right = image(frames_[index].right, stamp(index));
    result.left_info = info(stamp(index), false);
    result.right_info = info(stamp(index), true);
    return result;
  }

  geometry_msgs::TransformStamped extrinsic() const {
    return transformMsg(stamp(0), "base_link", kFrame, street_.cameraMount());
  }

  const StreetFrame& truth(int index) const { return frames_[index]; }

  Eigen::Isometry3d cameraMount() const { return street_.cameraMount(); }

  /// True pose of base_link in the world.
  Eigen::Isometry3d T_world_base(int index) const {
    return frames_[index].T_world_cam * street_.cameraMount().inverse();
  }

  sensor_msgs::ImagePtr image(const cv::Mat1b& pixels, ros::Time stamp) const {
    auto message = boost::make_shared<sensor_msgs::Image>();
    message->header.stamp = stamp;
    message->header.frame_id = kFrame;
    message->width = static_cast<uint32_t>(pixels.cols);
    message->height = static_cast<uint32_t>(pixels.rows);
    message->encoding = sensor_msgs::image_encodings::MONO8;
    message->step = message->width;
    message->data.resize(pixels.total());
    pixels.copyTo(cv::Mat1b(pixels.rows, pixels.cols, message->data.data()));
    return message;
  }

  sensor_msgs::CameraInfoPtr info(ros::Time stamp, bool right) const {
    const sensor_msgs::CameraInfoPtr message = cameraInfo(rig(), stamp, right);
    message->header.frame_id = kFrame;
    return message;
  }

 private:
  static StreetParams params(int frames, int seed) {
    StreetParams result;
    result.seed = seed;
    result.width = kWidth;
    result.height = kHeight;
    result.frames = frames;
    return result;
  }

  Street street_;
  std::vector<StreetFrame> frames_;
};

}  // namespace predictive_stereo
