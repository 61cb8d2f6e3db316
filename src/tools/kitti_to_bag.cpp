/// Converts a drive of KITTI's raw recordings to a bag in kitti2bag's layout.
#include <cv_bridge/cv_bridge.h>
#include <geometry_msgs/TwistStamped.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/NavSatFix.h>
#include <sensor_msgs/PointCloud2.h>
#include <sensor_msgs/point_cloud2_iterator.h>
#include <tf2_eigen/tf2_eigen.h>
#include <tf2_msgs/TFMessage.h>

#include <cstdio>
#include <cstring>

#include "nodelets/stereo_messages.h"
#include "nodelets/transforms.h"
#include "tools/bag_file.h"
#include "tools/command_line.h"
#include "tools/kitti_drive.h"
#include "tools/progress.h"

namespace predictive_stereo {
namespace {

/// Position of the inertial unit on KITTI's car as in kitti2bag, where base_link is the ground
/// projection of the rear axle's middle, shifted by half of the wheelbase.
Eigen::Isometry3d imuInBase() {
  Eigen::Isometry3d T_base_imu = Eigen::Isometry3d::Identity();
  T_base_imu.translation() << -2.71 / 2.0 - 0.05, 0.32, 0.93;
  return T_base_imu;
}

std::string cameraName(const KittiCamera& camera) {
  const char* names[] = {"camera_gray_left", "camera_gray_right", "camera_color_left",
                         "camera_color_right"};
  return names[camera.number];
}

sensor_msgs::CameraInfo cameraInfo(const KittiCamera& camera, cv::Size size) {
  sensor_msgs::CameraInfo info;
  info.header.frame_id = cameraName(camera);
  info.width = static_cast<uint32_t>(size.width);
  info.height = static_cast<uint32_t>(size.height);
  info.distortion_model = "plumb_bob";
  info.D.assign(camera.D.data(), camera.D.data() + camera.D.size());
  using RowMajor = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>;
  Eigen::Map<RowMajor>(info.K.data(), 3, 3) = camera.K;
  Eigen::Map<RowMajor>(info.R.data(), 3, 3) = camera.R_rect;
  Eigen::Map<RowMajor>(info.P.data(), 3, 4) = camera.P_rect;
  return info;
}

sensor_msgs::PointCloud2 pointCloud(const std::vector<LidarPoint>& points) {
  sensor_msgs::PointCloud2 cloud;
  cloud.header.frame_id = "velo_link";
  using sensor_msgs::PointField;
  sensor_msgs::PointCloud2Modifier modifier(cloud);
  modifier.setPointCloud2Fields(4, "x", 1, PointField::FLOAT32, "y", 1, PointField::FLOAT32, "z", 1,
                                PointField::FLOAT32, "i", 1, PointField::FLOAT32);
  modifier.resize(points.size());
  std::memcpy(cloud.data.data(), points.data(), cloud.data.size());
  cloud.is_dense = true;
  return cloud;
}

/// Writes a drive with the topics of kitti2bag's `raw_synced` bags, see its help.
///
/// K and D of a camera_info are of the unrectified, R and P of the rectified camera; each camera
/// has its own stamps. /tf_static has base_link to imu_link, from there to velo_link and the
/// cameras; it is repeated with every frame.
///
/// kitti2bag writes the inertial unit's pose as that of base_link; here it is moved along the lever
/// arm, so that world -> imu_link is exact. In a drive without oxts, base_link is in the left
/// camera's centre (x forward, z up), the poses are those of poses_gt_cam0.txt, and there is no
/// imu_link or velo_link.
class DriveWriter {
 public:
  DriveWriter(const KittiDrive& drive, BagFile& bag)
      : drive_(drive),
        bag_(bag),
        has_oxts_(drive.hasOxts()),
        left_stamps_(drive.stamps(KittiDrive::imageFolder(drive.leftCamera()))),
        right_stamps_(drive.stamps(KittiDrive::imageFolder(drive.rightCamera()))),
        oxts_stamps_(has_oxts_ ? drive.stamps("oxts") : left_stamps_) {
    for (int frame = 0; frame < drive.frames() && lidar_stamps_.empty(); ++frame)
      if (drive.hasLidar(frame)) lidar_stamps_ = drive.stamps("velodyne_points");
    setTransforms();
  }

  void write(int frame) {
    const auto i = static_cast<size_t>(frame);
    writeTransforms(i);
    if (has_oxts_) writeOxts(frame, rosTime(Stamp(oxts_stamps_[i])));
    writeImage(drive_.leftCamera(), frame, rosTime(Stamp(left_stamps_[i])));
    writeImage(drive_.rightCamera(), frame, rosTime(Stamp(right_stamps_[i])));
    if (drive_.hasLidar(frame)) {
      sensor_msgs::PointCloud2 cloud = pointCloud(drive_.lidar(frame));
      cloud.header.stamp = rosTime(Stamp(lidar_stamps_[i]));
      bag_.write("/kitti/velo/pointcloud", cloud.header.stamp, cloud);
    }
  }

 private:
  void setTransforms() {
    const Eigen::Isometry3d T_left_right =
        drive_.leftCamera().T_cam_cam0 * drive_.rightCamera().T_cam_cam0.inverse();
    const Eigen::Isometry3d T_optical_body(bodyFromOptical().transpose());
    Eigen::Isometry3d T_parent_left, T_left_base;
    std::string parent = "base_link";
    if (has_oxts_) {
      parent = "imu_link";
      T_parent_left = (drive_.T_cam_velo() * drive_.T_velo_imu()).inverse();
      T_left_base = (imuInBase() * T_parent_left).inverse();
      static_.transforms = {
          transformMsg({}, "base_link", "imu_link", imuInBase()),
          transformMsg({}, "imu_link", "velo_link", drive_.T_velo_imu().inverse())};
    } else {
      T_left_base = T_optical_body;
      T_parent_left = T_left_base.inverse();
    }
    static_.transforms.push_back(
        transformMsg({}, parent, cameraName(drive_.leftCamera()), T_parent_left));
    static_.transforms.push_back(
        transformMsg({}, parent, cameraName(drive_.rightCamera()), T_parent_left * T_left_right));
    if (const auto poses = drive_.poses())
      for (const Eigen::Isometry3d& T_world_left : *poses) {
        // Without oxts the world has the axes of the first camera: rotate it so that z is up.
        const Eigen::Isometry3d upright =
            has_oxts_ ? Eigen::Isometry3d::Identity() : T_optical_body.inverse();
        dynamic_.push_back(
            transformMsg({}, "world", "base_link", upright * T_world_left * T_left_base));
      }
  }

  void writeTransforms(size_t i) {
    const ros::Time stamp = rosTime(Stamp(oxts_stamps_[i]));
    for (auto& transform : static_.transforms) transform.header.stamp = stamp;
    bag_.write("/tf_static", stamp, static_);
    if (dynamic_.empty()) return;
    tf2_msgs::TFMessage message;
    message.transforms = {dynamic_[i]};
    message.transforms[0].header.stamp = stamp;
    bag_.write("/tf", stamp, message);
  }

  /// Reads the fields by their numbers in dataformat.txt.
  void writeOxts(int frame, const ros::Time& stamp) {
    const OxtsRecord record = drive_.oxts(frame);
    std_msgs::Header header;
    header.stamp = stamp;
    header.frame_id = "imu_link";

    const auto vector = [&](size_t first) {
      geometry_msgs::Vector3 v;
      v.x = record.fields[first];
      v.y = record.fields[first + 1];
      v.z = record.fields[first + 2];
      return v;
    };
    sensor_msgs::Imu imu;
    imu.header = header;
    imu.orientation = tf2::toMsg(record.attitude());
    imu.linear_acceleration = vector(14);  // af, al, au
    imu.angular_velocity = vector(20);     // wf, wl, wu
    bag_.write("/kitti/oxts/imu", stamp, imu);

    sensor_msgs::NavSatFix fix;
    fix.header = header;
    fix.latitude = record.latitude_deg();
    fix.longitude = record.longitude_deg();
    fix.altitude = record.altitude_m();
    fix.status.service = sensor_msgs::NavSatStatus::SERVICE_GPS;
    bag_.write("/kitti/oxts/gps/fix", stamp, fix);

    geometry_msgs::TwistStamped twist;
    twist.header = header;
    twist.twist.linear = vector(8);    // vf, vl, vu
    twist.twist.angular = vector(20);  // wf, wl, wu
    bag_.write("/kitti/oxts/gps/vel", stamp, twist);
  }

  void writeImage(const KittiCamera& camera, int frame, const ros::Time& stamp) {
    sensor_msgs::CameraInfo info = cameraInfo(camera, drive_.rig().size);
    info.header.stamp = stamp;
    const cv_bridge::CvImage image(info.header, camera.number < 2 ? "mono8" : "bgr8",
                                   drive_.image(camera, frame));
    const std::string camera_topic = "/kitti/" + cameraName(camera);
    bag_.write(camera_topic + "/image_raw", stamp, *image.toImageMsg());
    bag_.write(camera_topic + "/camera_info", stamp, info);
  }

  const KittiDrive& drive_;
  BagFile& bag_;
  bool has_oxts_;
  std::vector<int64_t> left_stamps_, right_stamps_, oxts_stamps_, lidar_stamps_;
  tf2_msgs::TFMessage static_;
  std::vector<geometry_msgs::TransformStamped> dynamic_;
};

}  // namespace

int runProgram(const CommandLine& command_line) {
  const auto& arguments = command_line.positional();
  if (arguments.size() != 3) throw UsageError("expected DATE_DIR DRIVE OUT.bag");
  const std::string cameras = command_line.get("cameras", "gray");
  if (cameras != "gray" && cameras != "color")
    throw UsageError("--cameras = " + cameras + ": must be gray or color");

  catchInterruptions();
  const KittiDrive drive(arguments[0], arguments[1], cameras == "gray" ? 0 : 2);
  {
    BagFile bag(arguments[2]);
    DriveWriter writer(drive, bag);
    Progress progress(drive.name(), drive.frames());
    for (int frame = 0; frame < drive.frames(); ++frame) {
      writer.write(frame);
      progress.update(frame);
      throwIfInterrupted();
    }
    bag.finish();
  }
  std::printf("%s: %d frames of %s\n", arguments[2].c_str(), drive.frames(), drive.name().c_str());
  return 0;
}

}  // namespace predictive_stereo
