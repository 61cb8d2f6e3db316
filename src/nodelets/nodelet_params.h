/// All parameters of the nodelets, with their defaults: `~name` of each. Knows no ROS, so that
/// tools without ROS read the same files.
#pragma once

#include <string>

#include "predictive_stereo/pipeline.h"

namespace predictive_stereo {

struct SyncParams {
  bool approximate_sync = true;  ///< stamps may differ by sync_tolerance; false: must be equal
  int queue_size = 10;           ///< messages of each topic that wait for their partners
  double sync_tolerance = 0.01;  ///< [s] less than half the time between two frames
  /// raw, compressed (JPEG or PNG), or another for which image_transport has a plugin.
  std::string image_transport = "raw";

  template <class Visitor>
  void visit(Visitor&& v) {
    v("approximate_sync", approximate_sync);
    v("queue_size", queue_size, 1, 1000);
    v("sync_tolerance", sync_tolerance, 0.0, 1.0);
    v("image_transport", image_transport);
  }
};

struct EgoMotionProcessorParams {
  std::string odom_frame = "odom";       ///< fixed frame of the pose
  std::string base_frame = "base_link";  ///< the robot; empty: the left camera itself
  double max_gap = 1.0;                  ///< [s] frames further apart do not belong together
  EgoMotionParams ego_motion;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("odom_frame", odom_frame);
    v("base_frame", base_frame);
    v("max_gap", max_gap, 0.01, 3600.0);
    ego_motion.visit(v);
  }
};

struct DisparityProcessorParams {
  double max_gap = 1.0;  ///< [s] frames further apart do not belong together
  DisparityParams disparity;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("max_gap", max_gap, 0.01, 3600.0);
    disparity.visit(v);
  }
};

struct MovingObjectsProcessorParams {
  double max_gap = 1.0;  ///< [s] frames further apart do not belong together
  DetectionParams detection;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("max_gap", max_gap, 0.01, 3600.0);
    detection.visit(v);
  }
};

struct EgoMotionNodeletParams {
  bool publish_tf = true;
  /// Works only while somebody subscribes to the odometry, with a pose that starts anew each time.
  /// Otherwise it never sleeps where it publishes tf: who listens to tf cannot be told.
  bool lazy = false;
  double transform_timeout = 0.2;  ///< [s] that a frame waits for base_frame -> camera
  int threads = 0;                 ///< of parallel loops, 0: all cores; see limitThreads
  /// Features on what MovingObjects marked in the frame before are ignored. The result then depends
  /// on whether the mask came in time.
  bool use_moving_mask = false;
  /// Fast turns: the gyroscope on the topic imu tells where to look for what was seen before. The
  /// images measure the motion all the same.
  bool use_imu = false;
  /// Without use_imu, the same from tf: a fixed frame against which tf knows how the camera turns.
  /// Empty: none.
  std::string guess_frame;
  SyncParams sync;
  EgoMotionProcessorParams processor;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("publish_tf", publish_tf);
    v("lazy", lazy);
    v("transform_timeout", transform_timeout, 0.0, 10.0);
    v("threads", threads, 0, 1024);
    v("use_moving_mask", use_moving_mask);
    v("use_imu", use_imu);
    v("guess_frame", guess_frame);
    sync.visit(v);
    processor.visit(v);
  }
};

/// Of points2 and points2_static.
struct PointsParams {
  double max_range_m = 0;  ///< points farther from the camera are left out; 0: none are
  int stride = 1;          ///< every so many rows and columns become points

  template <class Visitor>
  void visit(Visitor&& v) {
    v("max_range_m", max_range_m, 0.0, 10000.0);
    v("stride", stride, 1, 64);
  }
};

struct DisparityNodeletParams {
  std::string odom_frame = "odom";  ///< fixed frame against which tf knows the camera's motion
  double transform_timeout = 0.2;   ///< [s] that a frame waits for its motion, and for what moves
  int threads = 0;                  ///< of parallel loops, 0: all cores; see limitThreads
  SyncParams sync;
  PointsParams points;
  DisparityProcessorParams processor;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("odom_frame", odom_frame);
    v("transform_timeout", transform_timeout, 0.0, 10.0);
    v("threads", threads, 0, 1024);
    sync.visit(v);
    v("points", points);
    processor.visit(v);
  }
};

struct MovingObjectsNodeletParams {
  std::string odom_frame = "odom";      ///< fixed frame in which velocities are given
  double transform_timeout = 0.2;       ///< [s] that a frame waits for its pose
  int threads = 0;                      ///< of parallel loops, 0: all cores; see limitThreads
  int queue_size = 20;                  ///< left images that wait for their disparity
  std::string image_transport = "raw";  ///< of the left image: as of Disparity
  MovingObjectsProcessorParams processor;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("odom_frame", odom_frame);
    v("transform_timeout", transform_timeout, 0.0, 10.0);
    v("threads", threads, 0, 1024);
    v("queue_size", queue_size, 1, 1000);
    v("image_transport", image_transport);
    processor.visit(v);
  }
};

/// The parameters of all three, as a config file has them: under the nodelets' usual names.
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
