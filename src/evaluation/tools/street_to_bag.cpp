/// Writes a synthetic sequence to a bag: a stereo camera and the ground truth.
#include <cv_bridge/cv_bridge.h>
#include <nav_msgs/Odometry.h>
#include <predictive_stereo/MovingObjectArray.h>
#include <ros/names.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/image_encodings.h>
#include <stereo_msgs/DisparityImage.h>
#include <tf2_eigen/tf2_eigen.h>
#include <tf2_msgs/TFMessage.h>

#include <boost/make_shared.hpp>
#include <cstdio>
#include <map>

#include "evaluation/simulation/scene.h"
#include "evaluation/simulation/street.h"
#include "nodelets/transforms.h"
#include "tools/bag_file.h"
#include "tools/command_line.h"
#include "tools/progress.h"
#include "tools/stereo_bag.h"

namespace predictive_stereo {
namespace {

std::string helpText() {
  std::string text = kToolHelp;
  for (const simulation::Scene& scene : simulation::scenes()) {
    std::string name = scene.name;
    name.resize(std::max<size_t>(name.size(), 17), ' ');
    text += "  " + name + " " + scene.summary + "\n";
  }
  return text;
}

constexpr char kOdomFrame[] = "odom", kBaseFrame[] = "base_link", kCameraFrame[] = "camera_link",
               kOpticalFrame[] = "camera_left_optical_frame";
constexpr double kEpoch_s = 1577836800;  // 2020-01-01: a stamp of 0 means "none" in ROS

// Writes a message as if from a latching publisher, so that players latch it again.
template <class Message>
void writeLatched(const std::string& topic, const ros::Time& time, const Message& message,
                  BagFile& bag) {
  const auto connection = boost::make_shared<ros::M_string>();
  (*connection)["type"] = ros::message_traits::datatype(message);
  (*connection)["md5sum"] = ros::message_traits::md5sum(message);
  (*connection)["message_definition"] = ros::message_traits::definition(message);
  (*connection)["latching"] = "1";
  (*connection)["callerid"] = "/street_to_bag";
  bag.write(topic, time, message, connection);
}

sensor_msgs::CameraInfo cameraInfo(const std_msgs::Header& header, const StereoRig& rig,
                                   bool right) {
  sensor_msgs::CameraInfo info;
  info.header = header;
  info.width = static_cast<uint32_t>(rig.size.width);
  info.height = static_cast<uint32_t>(rig.size.height);
  info.distortion_model = "plumb_bob";
  info.D.assign(5, 0.0);
  const double cx = right ? rig.cx_right_px : rig.cx_left_px;
  info.K = {rig.fx_px, 0, cx, 0, rig.fy_px, rig.cy_px, 0, 0, 1};
  info.R = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  const double shift = right ? -rig.disparityTimesDepth() : 0.0;
  info.P = {rig.fx_px, 0, cx, shift, 0, rig.fy_px, rig.cy_px, 0, 0, 0, 1, 0};
  return info;
}

stereo_msgs::DisparityImage disparityMessage(const std_msgs::Header& header, const StereoRig& rig,
                                             const cv::Mat1f& disparity_px) {
  stereo_msgs::DisparityImage message;
  message.header = header;
  cv_bridge::CvImage(header, sensor_msgs::image_encodings::TYPE_32FC1, disparity_px)
      .toImageMsg(message.image);
  message.f = static_cast<float>(rig.fx_px);
  message.T = static_cast<float>(rig.baseline_m);
  message.valid_window.width = static_cast<uint32_t>(rig.size.width);
  message.valid_window.height = static_cast<uint32_t>(rig.size.height);
  double largest = 0;
  cv::minMaxLoc(disparity_px, nullptr, &largest);
  message.max_disparity = static_cast<float>(largest);
  return message;
}

tf2_msgs::TFMessage extrinsics(const ros::Time& stamp, const Eigen::Isometry3d& T_base_optical) {
  const Eigen::Isometry3d T_link_optical(bodyFromOptical());
  tf2_msgs::TFMessage message;
  message.transforms = {
      transformMsg(stamp, kBaseFrame, kCameraFrame, T_base_optical * T_link_optical.inverse()),
      transformMsg(stamp, kCameraFrame, kOpticalFrame, T_link_optical)};
  return message;
}

Eigen::Isometry3d basePose(const Street& street, double time_s) {
  return street.poseAt(time_s) * street.cameraMount().inverse();
}

nav_msgs::Odometry odometry(std_msgs::Header header, const Street& street,
                            const Eigen::Isometry3d& T_world_odom, double time_s) {
  header.frame_id = kOdomFrame;
  nav_msgs::Odometry message;
  message.header = header;
  message.child_frame_id = kBaseFrame;
  message.pose.pose = tf2::toMsg(T_world_odom.inverse() * basePose(street, time_s));
  // Velocity in the axes of the base, as a central difference over two milliseconds.
  const double half_s = 1e-3;
  const double before_s = std::max(0.0, time_s - half_s), after_s = time_s + half_s;
  const Eigen::Isometry3d T_before_after =
      basePose(street, before_s).inverse() * basePose(street, after_s);
  const Eigen::AngleAxisd turn(T_before_after.linear());
  const Eigen::Vector3d linear = T_before_after.translation() / (after_s - before_s);
  const Eigen::Vector3d angular = turn.angle() * turn.axis() / (after_s - before_s);
  tf2::toMsg(linear, message.twist.twist.linear);
  tf2::toMsg(angular, message.twist.twist.angular);
  return message;
}

MovingObjectArray movingObjects(const std_msgs::Header& header, const StreetFrame& frame,
                                const Eigen::Isometry3d& T_world_odom,
                                std::map<int, int>& first_seen) {
  MovingObjectArray message;
  message.header = header;
  for (const StreetMover& mover : frame.movers) {
    MovingObject object;
    object.id = static_cast<uint32_t>(mover.id);
    object.bbox.center.x = mover.box_px.x + 0.5 * mover.box_px.width;
    object.bbox.center.y = mover.box_px.y + 0.5 * mover.box_px.height;
    object.bbox.size_x = mover.box_px.width;
    object.bbox.size_y = mover.box_px.height;
    object.pose.position = tf2::toMsg(mover.centre_m);
    object.pose.orientation.w = 1;
    tf2::toMsg(mover.extent_m, object.size);
    const Eigen::Vector3d velocity = T_world_odom.linear().transpose() * mover.velocity_mps;
    tf2::toMsg(velocity, object.velocity);
    object.score = mover.visibleShare();
    object.age = static_cast<uint32_t>(frame.index -
                                       first_seen.emplace(mover.id, frame.index).first->second);
    object.distance = mover.distance_m;
    message.objects.push_back(object);
  }
  return message;
}

StreetParams paramsFrom(const CommandLine& line) {
  StreetParams params;
  params.scene = line.get("scene", params.scene);
  params.frames = line.getInt("frames", params.frames, 1);
  params.seed = line.getInt("seed", params.seed, 0);
  if (line.has("size")) {
    char rest = 0;
    if (std::sscanf(line.get("size").c_str(), "%dx%d%c", &params.width, &params.height, &rest) != 2)
      throw UsageError("--size = " + line.get("size") + ": must be WIDTHxHEIGHT, e.g. 1242x375");
  }
  params.rate_hz = line.getDouble("rate", 0);
  return params;
}

}  // namespace

int runProgram(const CommandLine& line) {
  if (line.positional().size() != 1)
    throw UsageError("give one bag to write, e.g. street_to_bag street.bag");
  const Street street(paramsFrom(line));
  const StereoRig& rig = street.rig();
  const Eigen::Isometry3d T_world_odom = basePose(street, street.exposureTimeOf(0));
  const std::string ns = cameraNamespace(line.get("namespace", "/street"));
  if (std::string error; !ros::names::validate(ns, error))
    throw UsageError("--namespace = " + ns + ": " + error);

  BagFile file(line.positional()[0], line.has("compress"));
  catchInterruptions();
  Progress progress(line.positional()[0], street.frames());
  const ros::Time begin(kEpoch_s);
  writeLatched("/tf_static", begin, extrinsics(begin, street.cameraMount()), file);
  std::map<int, int> first_seen;
  for (int i = 0; i < street.frames(); ++i) {
    throwIfInterrupted();
    const StreetFrame frame = street.render(i);
    std_msgs::Header header;
    header.seq = static_cast<uint32_t>(i);
    header.stamp = begin + ros::Duration(frame.stamp_s);
    header.frame_id = kOpticalFrame;
    const auto write = [&](const char* topic, const auto& message) {
      file.write(ns + "/" + topic, header.stamp, message);
    };
    const auto writeImage = [&](const char* topic, const cv::Mat1b& image) {
      write(topic, *cv_bridge::CvImage(header, "mono8", image).toImageMsg());
    };
    writeImage("left/image_rect", frame.left);
    write("left/camera_info", cameraInfo(header, rig, false));
    writeImage("right/image_rect", frame.right);
    write("right/camera_info", cameraInfo(header, rig, true));
    write("truth/disparity", disparityMessage(header, rig, frame.disparity_px));
    write("truth/odometry", odometry(header, street, T_world_odom, street.exposureTimeOf(i)));
    write("truth/moving_objects", movingObjects(header, frame, T_world_odom, first_seen));
    progress.update(i);
  }
  file.finish();
  return 0;
}

}  // namespace predictive_stereo

int main(int argc, char** argv) {
  return predictive_stereo::runTool(argc, argv, predictive_stereo::helpText(),
                                    predictive_stereo::runProgram);
}
