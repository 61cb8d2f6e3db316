/// Detection of moving objects: the default scheme, and that of the paper's section 4.
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "predictive_stereo/disparity_motion.h"
#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/params.h"
#include "predictive_stereo/pose_state.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

/// One moving object.
struct DetectedObject {
  int id = 0;         ///< the same in all frames while the object is tracked; never another's
  cv::Rect2f box_px;  ///< in the left image
  Eigen::Vector3d centre_m =
      Eigen::Vector3d::Zero();  ///< centre of its 3-D box in the left camera's optical frame
  Eigen::Vector3d size_m =
      Eigen::Vector3d::Zero();  ///< of its 3-D box along the axes of that frame
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();         ///< in the odom frame
  Eigen::Matrix3d velocity_covariance = Eigen::Matrix3d::Zero();  ///< [m^2/s^2]; zero: not known
  double score = 0;                                               ///< confidence, 0..1
  int age = 0;            ///< number of frames from the first detection to this one, see detect()
  double distance_m = 0;  ///< depth of its nearest part, along the optical axis
};

/// Input of the detector for one frame. All maps have rig.size; unknown disparities are
/// DisparityRange::invalid(). Only the paper's scheme uses the predicted maps: for the default one
/// they may be empty.
struct DetectionInput {
  double stamp_s = 0;  ///< time of the frame since any epoch
  StereoRig rig;
  cv::Mat1b left;
  cv::Mat1f measured_disparity_px, measured_variance_px2;
  cv::Mat1f predicted_disparity_px, predicted_variance_px2;
  /// Without a known pose nothing is measured in the odom frame; tracks and their velocities stay,
  /// for up to 1 s if the scheme finds nothing without a pose.
  PoseState pose_state = PoseState::kLost;
  /// Pose of the left camera's optical frame in the odom frame.
  Eigen::Isometry3d T_odom_cam = Eigen::Isometry3d::Identity();
  /// Covariance of the motion since the previous frame with a known pose, see
  /// CameraMotion::covariance. What is no covariance (zero, not finite) counts as unknown: 1.5 cm
  /// and 0.2 mrad.
  Matrix6d motion_covariance = Matrix6d::Zero();
};

struct Detections {
  std::vector<DetectedObject> objects;
  cv::Mat1b mask;  ///< 255 on pixels of the objects, 0 elsewhere; of rig.size
};

enum class DetectionScheme {
  /// Differences of image and disparity from a static scene, verified, tracked over frames.
  kDefault,
  kPaper,  ///< section 4: windows of large disparity differences, merged; each frame by itself
};

/// The paper's section 4, as a reference to compare with. It detects motion that changes disparity,
/// with many false positives.
struct PaperDetectionParams {
  int smallest_window_width_px = 20;
  int smallest_window_height_px = 20;
  int largest_window_width_px = 75;
  int largest_window_height_px = 50;
  int window_sizes = 4;  ///< from the smallest to the largest in equal steps, both included
  int step_px = 5;       ///< between windows; doubled while more than 2000 of a frame differ
  double skipped_top = 1.0 / 3.0;  ///< share of the image's rows, from the top, without windows
  double min_mean_difference_px = 1.5;  ///< of a window's pixels; unknown ones count as 0
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

/// The default scheme: an object moves where a static scene does not explain the image and the
/// disparities, and another rigid motion does.
struct MotionDetectionParams {
  // Points that are tracked back into a past frame.
  double min_mismatch = 0.4;    ///< image difference from a static scene, relative to the texture
  double min_mahalanobis = 20;  ///< squared distance from a static point, in 3 dimensions
  // Groups of these points.
  double link_distance_m = 2.5;  ///< between them, across the line of sight; 0.6 times it along
  int min_tracks = 4;
  // Dense disparity residuals.
  /// Mean over 12x12 pixels of the rescaled image; over an obstacle: half of it.
  double dense_min_residual_px = 0.7;
  // Verification in the object's disparity layer.
  double layer_margin_m = 0.6;  ///< of the layer before and behind the depths of the points
  double min_explained = 0.6;   ///< share of the layer that the object's motion explains better
  // Limits of a plausible object; the defaults are for roads.
  double min_height_m = 0.8, max_height_m = 4.5;
  double min_width_m = 0.2, max_width_m = 9;
  double max_foot_m = 1.2;  ///< height of its lower end above road or floor, where this is visible
  double largest_speed_mps = 40;  ///< over ground; 3 sigma of a new object's speed

  template <class Visitor>
  void visit(Visitor&& v) {
    v("min_mismatch", min_mismatch, 0.01, 10.0);
    v("min_mahalanobis", min_mahalanobis, 0.0, 1e6);
    v("link_distance_m", link_distance_m, 0.01, 100.0);
    v("min_tracks", min_tracks, 2, 1000);
    v("dense_min_residual_px", dense_min_residual_px, 0.05, 100.0);
    v("layer_margin_m", layer_margin_m, 0.1, 100.0);
    v("min_explained", min_explained, 0.0, 1.0);
    v("min_height_m", min_height_m, 0.0, 100.0);
    v("max_height_m", max_height_m, 0.1, 100.0);
    v("min_width_m", min_width_m, 0.0, 100.0);
    v("max_width_m", max_width_m, 0.1, 100.0);
    v("max_foot_m", max_foot_m, 0.0, 100.0);
    v("largest_speed_mps", largest_speed_mps, 0.1, 1000.0);
  }
};

/// Tracking of objects over frames.
struct TrackingParams {
  int confirm_frames = 2;  ///< an object is reported after detections in this many frames ...
  /// ... whose sum of ln(score / (1 - score) * pixels / 1000) is at least this
  double confirm_evidence = 5;
  int max_missed_frames = 2;     ///< an object is dropped after more frames without detection
  double min_iou = 0.2;          ///< of predicted and observed box, to associate them
  double acceleration_mps2 = 4;  ///< standard deviation of an object's acceleration

  template <class Visitor>
  void visit(Visitor&& v) {
    v("confirm_frames", confirm_frames, 1, 8);
    v("confirm_evidence", confirm_evidence, -100.0, 100.0);
    v("max_missed_frames", max_missed_frames, 0, 16);
    v("min_iou", min_iou, 0.0, 1.0);
    v("acceleration_mps2", acceleration_mps2, 0.01, 100.0);
  }
};

struct DetectionParams {
  DisparityRange range;  ///< of the disparity maps; no parameter of users: it comes with the maps
  DetectionScheme scheme = DetectionScheme::kDefault;
  MotionDetectionParams motion;
  PaperDetectionParams paper;
  TrackingParams tracking;  ///< the paper's scheme reports every object at once

  template <class Visitor>
  void visit(Visitor&& v) {
    v("scheme", scheme,
      Choices<DetectionScheme>{{"default", DetectionScheme::kDefault},
                               {"paper", DetectionScheme::kPaper}});
    v("motion", motion);
    v("paper", paper);
    v("tracking", tracking);
  }
};

/// Detects moving objects and tracks them over frames.
class MovingObjectDetector {
 public:
  /// @throws std::invalid_argument if a parameter is outside its limits, or if width or height of
  ///   paper/largest_window is below that of paper/smallest_window.
  explicit MovingObjectDetector(const DetectionParams& params);
  ~MovingObjectDetector();
  MovingObjectDetector(MovingObjectDetector&&) noexcept;
  MovingObjectDetector& operator=(MovingObjectDetector&&) noexcept;

  /// Another rig than before resets the detector. If only cx_right_px differs, the disparities of
  /// the past frames are corrected by the difference instead.
  /// Default scheme: a frame whose left image equals that of the previous frame, less than 1 s
  /// later and with a known motion, is that frame, shown again. It has the same objects; no age
  /// grows.
  /// @param detections  overwritten; buffers of the right size are reused.
  /// @throws std::invalid_argument if rig.size is empty, or if a map does not have rig.size.
  void detect(const DetectionInput& input, Detections& detections);
  /// Sets parameters for the next frame. Tracks are kept, unless scheme or range change.
  /// @throws std::invalid_argument as the constructor does; the parameters are then unchanged.
  void setParams(const DetectionParams& params);
  /// Forgets all tracks and past frames.
  void reset();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace predictive_stereo
