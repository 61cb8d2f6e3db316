/// Small bags of one stereo camera, with faults.
#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <tf2_msgs/TFMessage.h>

#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

namespace predictive_stereo {

/// Description of a small bag with one stereo camera; each test adds one fault.
struct Recording {
  std::string left = "/stereo/left/image_rect", right = "/stereo/right/image_rect";
  std::string left_info = "/stereo/left/camera_info", right_info = "/stereo/right/camera_info";
  std::string encoding = "mono8", left_frame = "left_optical_frame";
  unsigned width = 64, right_width = 64, calibrated_width = 64, height = 32;
  double right_P3 = -30;
  double period_s = 0.1, right_delay_s = 0;
  std::vector<double> stamps_s;  // empty: ten, one per period
  bool zero_stamps = false;
  size_t infos = 1000;  // only with the first images
  bool extrinsic = true, optical = true;
  std::string base = "base_link";
  std::string base_parent;  // parent of base_link in /tf ...
  std::string footprint;    // ... or of this frame, to which base_link is fixed
  double tf_late_s = 0;     // recorded so long after its stamp
  int first_tf = 0;         // frame
  uint8_t grey = 100;
  bool compressed = false, broken = false;
  std::vector<std::string> others;  // more topics
  std::vector<std::string> odometries;
  boost::array<double, 9> K{{100, 0, 32, 0, 100, 16, 0, 0, 1}}, R{{1, 0, 0, 0, 1, 0, 0, 0, 1}};
};

inline sensor_msgs::Image image(const Recording& recording, unsigned width, ros::Time stamp) {
  sensor_msgs::Image message;
  message.header.frame_id = recording.left_frame;
  message.header.stamp = stamp;
  message.width = width;
  message.height = recording.height;
  message.encoding = recording.encoding;
  const unsigned bytes = recording.encoding == "mono16"  ? 2
                         : recording.encoding == "bgr8"  ? 3
                         : recording.encoding == "32FC1" ? 4
                                                         : 1;
  message.step = width * bytes;
  message.data.resize(message.step * message.height, recording.grey);
  return message;
}

inline sensor_msgs::CompressedImage packed(const Recording& recording,
                                           const sensor_msgs::Image& image) {
  sensor_msgs::CompressedImage message;
  message.header = image.header;
  message.format = "mono8; jpeg compressed ";
  if (recording.broken)
    message.data = {1, 2, 3};
  else
    cv::imencode(
        ".jpg",
        cv::Mat1b(static_cast<int>(image.height), static_cast<int>(image.width), recording.grey),
        message.data);
  return message;
}

inline sensor_msgs::CameraInfo info(const Recording& recording, double P3, ros::Time stamp) {
  sensor_msgs::CameraInfo message;
  message.header.frame_id = recording.left_frame;
  message.header.stamp = stamp;
  message.width = recording.calibrated_width;
  message.height = recording.height;
  message.K = recording.K;
  message.R = recording.R;
  message.P = {100, 0, 32, P3, 0, 100, 16, 0, 0, 0, 1, 0};
  return message;
}

inline tf2_msgs::TFMessage transform(const std::string& parent, const std::string& child,
                                     ros::Time stamp) {
  geometry_msgs::TransformStamped one;
  one.header.stamp = stamp;
  one.header.frame_id = parent;
  one.child_frame_id = child;
  one.transform.rotation.w = 1;
  tf2_msgs::TFMessage message;
  message.transforms.push_back(one);
  return message;
}

// Of a camera that looks ahead.
inline geometry_msgs::Quaternion optical() {
  geometry_msgs::Quaternion q;
  q.x = q.z = -0.5;
  q.y = q.w = 0.5;
  return q;
}

inline void write(const Recording& recording, const std::string& path) {
  rosbag::Bag bag(path, rosbag::bagmode::Write);
  const ros::Time begin(1000);
  std::vector<double> stamps_s = recording.stamps_s;
  if (stamps_s.empty())
    for (int i = 0; i < 10; ++i) stamps_s.push_back(i * recording.period_s);
  if (recording.extrinsic) {
    tf2_msgs::TFMessage mount = transform(recording.base, recording.left_frame, begin);
    if (recording.optical) mount.transforms[0].transform.rotation = optical();
    bag.write("/tf_static", begin, mount);
  }
  for (const std::string& topic : recording.odometries)
    bag.write(topic, begin, nav_msgs::Odometry());
  for (const std::string& topic : recording.others)
    bag.write(topic, begin, image(recording, recording.width, begin));
  for (size_t i = 0; i < stamps_s.size(); ++i) {
    const ros::Time now = begin + ros::Duration(recording.period_s * static_cast<double>(i));
    const auto stamp = [&](double offset_s) {
      return recording.zero_stamps ? ros::Time() : begin + ros::Duration(stamps_s[i] + offset_s);
    };
    const ros::Time left = stamp(0), right = stamp(recording.right_delay_s);
    const auto writeImage = [&](const std::string& topic, unsigned width, ros::Time stamp) {
      if (topic.empty()) return;
      const sensor_msgs::Image message = image(recording, width, stamp);
      if (recording.compressed)
        bag.write(topic + "/compressed", now, packed(recording, message));
      else
        bag.write(topic, now, message);
    };
    writeImage(recording.left, recording.width, left);
    writeImage(recording.right, recording.right_width, right);
    if (!recording.left_info.empty() && i < recording.infos)
      bag.write(recording.left_info, now, info(recording, 0, left));
    if (!recording.right_info.empty() && i < recording.infos)
      bag.write(recording.right_info, now, info(recording, recording.right_P3, right));
    const std::string& footprint = recording.footprint;
    if (!footprint.empty()) bag.write("/tf_static", now, transform(footprint, "base_link", now));
    if (!recording.base_parent.empty() && static_cast<int>(i) >= recording.first_tf)
      bag.write("/tf", now + ros::Duration(recording.tf_late_s),
                transform(recording.base_parent, footprint.empty() ? "base_link" : footprint, now));
  }
  bag.close();
}

}  // namespace predictive_stereo
