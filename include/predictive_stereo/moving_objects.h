/// Detection of moving objects from predicted and measured disparities: the paper's
/// section 4.
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/params.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

/// One object that moves by itself.
struct DetectedObject {
  int id = 0;         ///< stable while the object is followed
  cv::Rect2f box_px;  ///< in the left image
  Eigen::Vector3d centre_m =
      Eigen::Vector3d::Zero();  ///< centre of its 3-D box in the left camera's optical frame
  Eigen::Vector3d size_m =
      Eigen::Vector3d::Zero();  ///< of its 3-D box along the axes of that frame
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();         ///< in the odom frame
  Eigen::Matrix3d velocity_covariance = Eigen::Matrix3d::Zero();  ///< [m^2/s^2]
  double score = 0;                                               ///< 0..1
  int age = 0;            ///< frames since it was first seen
  double distance_m = 0;  ///< from the left camera to the nearest part of it
};

/// One frame as the detector sees it. All maps have rig.size; see Match, Prediction for invalid
/// values. The predicted ones are for the paper's scheme.
struct DetectionInput {
  double stamp_s = 0;
  StereoRig rig;
  cv::Mat1b left;
  cv::Mat1f measured_disparity_px, measured_variance_px2;
  cv::Mat1f predicted_disparity_px, predicted_variance_px2;
  /// Pose of the left camera's optical frame in the odom frame; not set: unknown in this frame.
  bool has_pose = false;
  Eigen::Isometry3d T_odom_cam = Eigen::Isometry3d::Identity();
};

struct Detections {
  std::vector<DetectedObject> objects;
  cv::Mat1b mask;  ///< 255 on pixels of the objects
};

enum class DetectionScheme {
  kDefault,  ///< images and disparities against the static world, verified, followed over frames
  kPaper,    ///< section 4: windows of large disparity differences, merged; each frame by itself
};

/// The paper's section 4. It finds what changes disparity, and much else: a reference to compare
/// with.
struct PaperDetectionParams {
  int smallest_window_width_px = 20;
  int smallest_window_height_px = 20;
  int largest_window_width_px = 75;
  int largest_window_height_px = 50;
  int window_sizes = 4;  ///< from the smallest to the largest in equal steps, both included
  int step_px = 5;       ///< by which windows are moved
  double skipped_top = 1.0 / 3.0;       ///< share of the image's rows without windows
  double min_mean_difference_px = 1.5;  ///< of a window's pixels, unknown ones counting as 0
  double max_difference_px = 5.0;       ///< larger differences count as this one
  double min_merge_iou = 0.01;          ///< boxes that overlap by less are not merged
  int min_width_px = 25;                ///< smaller boxes are dropped
  int min_height_px = 25;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("smallest_window_width_px", smallest_window_width_px, 1, 4096);
    v("smallest_window_height_px", smallest_window_height_px, 1, 4096);
    v("largest_window_width_px", largest_window_width_px, 1, 4096);
    v("largest_window_height_px", largest_window_height_px, 1, 4096);
    v("window_sizes", window_sizes, 1, 32);
    v("step_px", step_px, 1, 256);
    v("skipped_top", skipped_top, 0.0, 0.99);
    v("min_mean_difference_px", min_mean_difference_px, 0.01, 256.0);
    v("max_difference_px", max_difference_px, 0.1, 256.0);
    v("min_merge_iou", min_merge_iou, 1e-6, 1.0);
    v("min_width_px", min_width_px, 0, 4096);
    v("min_height_px", min_height_px, 0, 4096);
  }
};

/// The default scheme: what the static world does not explain, in image and disparity, and another
/// motion does.
struct MotionDetectionParams {
  // Points that are followed back into a past frame.
  double min_mismatch = 0.4;          ///< of the image against the static world, by its texture
  int max_tracks = 500;               ///< points followed; an even sample where there are more
  double flow_sigma_px = 0.4;         ///< standard deviation of a point's position
  double ego_motion_sigma_m = 0.015;  ///< standard deviation of ego-motion since then
  double min_mahalanobis = 20;        ///< squared distance from the static world in 3 dimensions
  // Groups of them.
  double link_distance_m = 2.5;  ///< across the line of sight
  double link_depth_m = 1.5;     ///< along it
  int min_tracks = 4;
  // Dense disparity residuals.
  double dense_min_residual_px = 0.7;  ///< mean over 10x10 pixels
  double dense_min_area_m2 = 0.3;      ///< of a group of such pixels
  // Verification in the object's disparity layer.
  double layer_margin_m = 0.6;  ///< it reaches so far beyond the depths of the points
  double reach_m = 4;           ///< farthest that an object extends beyond its points
  double gap_m = 0.25;          ///< texture-less gaps within an object
  double min_explained = 0.6;   ///< share of the layer that the object's motion explains better
  // What an object may be: the defaults are those of roads.
  double min_height_m = 0.8, max_height_m = 4.5;
  double min_width_m = 0.2, max_width_m = 9;
  double max_foot_m = 1.2;  ///< above the road or floor is its lower end, where it can be seen
  double largest_speed_mps = 40;  ///< over ground

  template <class Visitor>
  void visit(Visitor&& v) {
    v("min_mismatch", min_mismatch, 0.01, 10.0);
    v("max_tracks", max_tracks, 10, 10000);
    v("flow_sigma_px", flow_sigma_px, 0.05, 10.0);
    v("ego_motion_sigma_m", ego_motion_sigma_m, 0.0, 10.0);
    v("min_mahalanobis", min_mahalanobis, 0.0, 1e6);
    v("link_distance_m", link_distance_m, 0.01, 100.0);
    v("link_depth_m", link_depth_m, 0.01, 100.0);
    v("min_tracks", min_tracks, 2, 1000);
    v("dense_min_residual_px", dense_min_residual_px, 0.05, 100.0);
    v("dense_min_area_m2", dense_min_area_m2, 0.0, 100.0);
    v("layer_margin_m", layer_margin_m, 0.1, 100.0);
    v("reach_m", reach_m, 0.1, 100.0);
    v("gap_m", gap_m, 0.0, 10.0);
    v("min_explained", min_explained, 0.0, 1.0);
    v("min_height_m", min_height_m, 0.0, 100.0);
    v("max_height_m", max_height_m, 0.1, 100.0);
    v("min_width_m", min_width_m, 0.0, 100.0);
    v("max_width_m", max_width_m, 0.1, 100.0);
    v("max_foot_m", max_foot_m, 0.0, 100.0);
    v("largest_speed_mps", largest_speed_mps, 0.1, 1000.0);
  }
};

/// Following objects over frames.
struct TrackingParams {
  int confirm_frames = 2;     ///< an object is reported once it was seen in so many ...
  int confirm_within = 3;     ///< ... of so many successive frames
  int max_missed_frames = 2;  ///< a confirmed object that is not seen for longer is dropped
  double min_iou = 0.2;       ///< of predicted and observed box, for these to belong together
  double min_overlap_of_smaller = 0.6;  ///< or share of the smaller of both boxes that is common
  double max_depth_ratio = 1.35;        ///< of predicted and observed distance
  double acceleration_mps2 = 4;         ///< standard deviation of an object's acceleration
  double largest_speed_mps = 30;        ///< 3 sigma of a new object's speed

  template <class Visitor>
  void visit(Visitor&& v) {
    v("confirm_frames", confirm_frames, 1, 8);
    v("confirm_within", confirm_within, 1, 8);
    v("max_missed_frames", max_missed_frames, 0, 16);
    v("min_iou", min_iou, 0.0, 1.0);
    v("min_overlap_of_smaller", min_overlap_of_smaller, 0.0, 1.0);
    v("max_depth_ratio", max_depth_ratio, 1.01, 10.0);
    v("acceleration_mps2", acceleration_mps2, 0.01, 100.0);
    v("largest_speed_mps", largest_speed_mps, 0.1, 300.0);
  }
};

struct DetectionParams {
  DisparityRange range;  ///< of the disparity maps
  DetectionScheme scheme = DetectionScheme::kDefault;
  MotionDetectionParams motion;
  PaperDetectionParams paper;
  TrackingParams tracking;  ///< the paper's scheme reports every object at once

  template <class Visitor>
  void visit(Visitor&& v) {
    v("range", range);
    v("scheme", scheme,
      Choices<DetectionScheme>{{"default", DetectionScheme::kDefault},
                               {"paper", DetectionScheme::kPaper}});
    v("motion", motion);
    v("paper", paper);
    v("tracking", tracking);
  }
};

class MovingObjectDetector {
 public:
  explicit MovingObjectDetector(const DetectionParams& params);
  ~MovingObjectDetector();
  MovingObjectDetector(MovingObjectDetector&&) noexcept;
  MovingObjectDetector& operator=(MovingObjectDetector&&) noexcept;

  /// Buffers of `detections` are reused where they have the right size. Another rig starts anew,
  /// except that where only cx_right_px differs the past's disparities are changed by the step.
  void detect(const DetectionInput& input, Detections& detections);
  /// Other parameters from the next frame on. Tracks go on, unless scheme or range become others.
  /// @throws std::invalid_argument for what the constructor refuses; nothing has changed then.
  void setParams(const DetectionParams& params);
  /// Forgets all tracks and the previous image.
  void reset();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace predictive_stereo
