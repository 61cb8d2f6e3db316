/// The camera's own motion from two consecutive stereo pairs.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "predictive_stereo/disparity_motion.h"
#include "predictive_stereo/params.h"
#include "predictive_stereo/row_alignment.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

struct EgoMotionParams {
  int features = 500;          ///< corners that are followed from frame to frame
  int max_disparity_px = 128;  ///< nearest points that are used
  RowAlignmentParams row_alignment;
  /// Whether to estimate a constant that all measured disparities lack, as after a small turn of
  /// one camera. It shows when the camera moves: near and far points then disagree on how far. On
  /// KITTI it takes 0.7 % off the length of the path.
  bool estimate_disparity_offset = true;
  double disparity_offset_sigma_px = 0.7;   ///< of that constant, before the first frame
  double disparity_offset_drift_px = 0.02;  ///< by which it wanders from frame to frame
  /// By which all disparities together change from frame to frame: cameras shake against each other
  /// on a bumpy road (on one KITTI drive by up to 0.8 px). 0: not at all.
  double disparity_jitter_px = 0.3;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("features", features, 50, 5000);
    v("max_disparity_px", max_disparity_px, 16, 512);
    v("row_alignment", row_alignment);
    v("estimate_disparity_offset", estimate_disparity_offset);
    v("disparity_offset_sigma_px", disparity_offset_sigma_px, 0.01, 10.0);
    v("disparity_offset_drift_px", disparity_offset_drift_px, 0.0, 1.0);
    v("disparity_jitter_px", disparity_jitter_px, 0.0, 5.0);
  }
};

enum class EgoMotionStatus {
  kFirstFrame,  ///< nothing to compare with: after construction, a reset or a changed size
  kTracked,
  kLost,  ///< too few features agree; the motion is identity and its covariance 9999
};

struct EgoMotionEstimate {
  EgoMotionStatus status = EgoMotionStatus::kFirstFrame;
  /// From the last frame that was not lost to this one; where that one is out of sight, from a
  /// later one. See `frames`.
  CameraMotion motion;
  int frames = 1;                ///< how many frames back `motion` starts: 1 is the previous one
  int features = 0;              ///< corners followed from there in both cameras
  int inliers = 0;               ///< those that agree with the motion
  double residual_px = 0;        ///< root mean square reprojection error of the inliers
  RowOffsetModel row_alignment;  ///< the vertical offset that the features' stereo matches showed
  /// To be added to measured disparities of this frame, and its standard deviation; 0 if switched
  /// off. Its change from frame to frame is known far better than its value.
  double disparity_offset_px = 0, disparity_offset_sigma_px = 0;
};

/// Stereo odometry: corners, tracks, depth by a search along the row, RANSAC, robust Gauss-Newton
/// on both cameras' reprojection errors. Motion is measured against the previous frame; against an
/// earlier one while the camera stands still, so that it does not drift, and after frames that show
/// nothing. Deterministic for a given input, whatever the number of threads.
class EgoMotion {
 public:
  explicit EgoMotion(const EgoMotionParams& params);
  ~EgoMotion();
  EgoMotion(EgoMotion&&) noexcept;
  EgoMotion& operator=(EgoMotion&&) noexcept;

  /// @param left, right  rectified 8-bit grey images of rig.size.
  /// @param moving_mask  empty, or 255 where features of the previous frame are to be ignored.
  /// @throws std::invalid_argument where sizes differ from rig.size.
  EgoMotionEstimate estimate(const cv::Mat1b& left, const cv::Mat1b& right, const StereoRig& rig,
                             const cv::Mat1b& moving_mask = {});
  /// Other parameters from the next frame on. What is known of the past is kept; switching
  /// estimate_disparity_offset forgets the past frames.
  /// @throws std::invalid_argument for parameters outside their limits; nothing has changed then.
  void setParams(const EgoMotionParams& params);
  /// Forgets the past frames. The estimated disparity offset, which belongs to the cameras, stays.
  void reset();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace predictive_stereo
