/// Detection of moving objects from what was predicted and what was measured: the paper's
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
struct MovingObject {
  int id = 0;                    ///< stable while the object is followed
  cv::Rect2f box_px;             ///< in the left image
  Eigen::Vector3d centre_m;      ///< centre of its 3-D box in the left camera's optical frame
  Eigen::Vector3d size_m;        ///< of its 3-D box along the axes of that frame
  Eigen::Vector3d velocity_mps;  ///< in the odom frame
  Eigen::Matrix3d velocity_covariance;  ///< [m^2/s^2]
  double score = 0;                     ///< 0..1
  int age = 0;                          ///< frames since it was first seen
  double distance_m = 0;                ///< from the left camera to the nearest part of it
};

/// One frame as the detector sees it. All maps have rig.size; see Match, Prediction for invalid
/// values.
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
  std::vector<MovingObject> objects;
  cv::Mat1b mask;      ///< 255 on pixels of the objects
  cv::Mat1f residual;  ///< (measured - predicted) / sigma, 0 where it cannot be told
};

struct DetectionParams {
  DisparityRange range;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("range", range);
  }
};

class MovingObjectDetector {
 public:
  explicit MovingObjectDetector(const DetectionParams& params);
  ~MovingObjectDetector();
  MovingObjectDetector(MovingObjectDetector&&) noexcept;
  MovingObjectDetector& operator=(MovingObjectDetector&&) noexcept;

  /// Buffers of `detections` are reused where they have the right size.
  void detect(const DetectionInput& input, Detections& detections);
  /// Forgets all tracks and the previous image.
  void reset();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace predictive_stereo
