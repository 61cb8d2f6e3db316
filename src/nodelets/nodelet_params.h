/// All parameters of the nodelets (`~name`) with their defaults. Does not depend on ROS, so tools
/// without ROS read the same files.
#pragma once

#include <string>

#include "predictive_stereo/pipeline.h"

namespace predictive_stereo {

struct SyncParams {
  bool approximate_sync = true;  ///< stamps may differ by sync_tolerance; false: must be equal
  int queue_size = 10;           ///< messages per topic that wait for their partners
  double sync_tolerance = 0.01;  ///< [s] less than half the time between two frames
  /// raw, compressed (JPEG or PNG), or one for which image_transport has a plugin.
  std::string image_transport = "raw";

  /// Messages of equal stamps.
  static SyncParams exact(int queue_size, const std::string& image_transport) {
    return {false, queue_size, 0, image_transport};
  }

  template <class Visitor>
  void visit(Visitor&& v) {
    v("approximate_sync", approximate_sync);
    v("queue_size", queue_size, 1, 1000);
    v("sync_tolerance", sync_tolerance, 0.0, 1.0);
    v("image_transport", image_transport);
  }
};

/// What the three nodelets have in common.
struct FrameNodeletParams {
  std::string odom_frame = "odom";  ///< fixed frame of the camera's pose, motion, and velocities
  double transform_timeout = 0.2;   ///< [s] longest wait of a frame for what other nodes send
  int threads = 0;                  ///< of parallel loops, 0: all cores; see limitThreads
  double max_gap = 1.0;             ///< [s] frames further apart do not belong together

  template <class Visitor>
  void visit(Visitor&& v) {
    v("odom_frame", odom_frame);
    v("transform_timeout", transform_timeout, 0.0, 10.0);
    v("threads", threads, 0, 1024);
    v("max_gap", max_gap, 0.01, 3600.0);
  }
};

struct EgoMotionNodeletParams : FrameNodeletParams {
  bool publish_tf = true;
  /// Runs only while a node subscribes to the odometry; the pose starts at the origin each time. If
  /// false, it always runs while it publishes tf, because subscribers of tf cannot be detected.
  bool lazy = false;
  /// Ignores features on objects that MovingObjects marked in the previous frame. The result then
  /// depends on whether the mask arrived in time.
  bool use_moving_mask = false;
  /// For fast turns: the gyroscope on the topic imu predicts where to search for features. The
  /// motion is still measured by the images.
  bool use_imu = false;
  /// Without use_imu, a rotation prior from tf: a fixed frame relative to which tf has the camera's
  /// rotation. Empty: no prior.
  std::string guess_frame;
  /// PNG of the left camera's size: white where it sees parts of the robot, e.g. an arm or a
  /// bonnet, black elsewhere. Nothing is measured on the white pixels. Empty: no such parts.
  std::string robot_mask;
  SyncParams sync;
  std::string base_frame = "base_link";  ///< frame of the robot; empty: the left camera
  EgoMotionParams ego_motion;

  template <class Visitor>
  void visit(Visitor&& v) {
    FrameNodeletParams::visit(v);
    v("publish_tf", publish_tf);
    v("lazy", lazy);
    v("use_moving_mask", use_moving_mask);
    v("use_imu", use_imu);
    v("guess_frame", guess_frame);
    v("robot_mask", robot_mask);
    sync.visit(v);
    v("base_frame", base_frame);
    ego_motion.visit(v);
  }
};

/// Parameters of points2 and points2_static.
struct PointsParams {
  double max_range_m = 0;  ///< points farther from the camera are left out; 0: no limit
  int stride = 1;          ///< only every n-th row and column becomes points

  template <class Visitor>
  void visit(Visitor&& v) {
    v("max_range_m", max_range_m, 0.0, 10000.0);
    v("stride", stride, 1, 64);
  }
};

struct DisparityNodeletParams : FrameNodeletParams {
  std::string robot_mask;  ///< as EgoMotionNodeletParams::robot_mask
  SyncParams sync;
  PointsParams points;
  DisparityParams disparity;

  template <class Visitor>
  void visit(Visitor&& v) {
    FrameNodeletParams::visit(v);
    v("robot_mask", robot_mask);
    sync.visit(v);
    v("points", points);
    disparity.visit(v);
  }
};

struct MovingObjectsNodeletParams : FrameNodeletParams {
  int queue_size = 20;                  ///< left images that wait for their disparity
  std::string image_transport = "raw";  ///< of the left image, see SyncParams
  DetectionParams detection;

  template <class Visitor>
  void visit(Visitor&& v) {
    FrameNodeletParams::visit(v);
    v("queue_size", queue_size, 1, 1000);
    v("image_transport", image_transport);
    detection.visit(v);
  }
};

struct RectifyNodeletParams {
  std::string image_transport = "raw";  ///< see SyncParams

  template <class Visitor>
  void visit(Visitor&& v) {
    v("image_transport", image_transport);
  }
};

/// The parameters of all three nodelets as in a config file: under the nodelets' usual names.
struct AllNodeletParams {
  EgoMotionNodeletParams ego_motion;
  DisparityNodeletParams disparity;
  MovingObjectsNodeletParams moving_objects;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("ego_motion", ego_motion);
    v("disparity", disparity);
    v("moving_objects", moving_objects);
  }
};

}  // namespace predictive_stereo
