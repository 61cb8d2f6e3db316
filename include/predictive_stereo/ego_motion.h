/// The camera's own motion from two consecutive stereo pairs.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "predictive_stereo/disparity_motion.h"
#include "predictive_stereo/params.h"
#include "predictive_stereo/path_covariance.h"
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
  double disparity_offset_sigma_px = 1.0;   ///< of that constant, before the first frame
  double disparity_offset_drift_px = 0.02;  ///< by which it wanders from frame to frame
  /// By which all disparities together change from frame to frame: cameras shake against each other
  /// on a bumpy road (on one KITTI drive by up to 0.8 px). 0: not at all.
  double disparity_jitter_px = 0.3;
  /// How well the cameras are calibrated, as standard deviations: it bounds how well a path can be
  /// known. All 0: perfectly, as in a simulation. Of the principal point: the direction of motion
  /// is off by it, divided by the focal length.
  double principal_point_sigma_px = 2;
  double scale_sigma = 0.002;  ///< of baseline and focal length, relative
  /// Of an error of disparities that grows from the image's centre to its borders. It makes a
  /// camera that drives straight on seem to turn.
  double disparity_tilt_sigma_px = 0.15;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("features", features, 50, 5000);
    v("max_disparity_px", max_disparity_px, 16, 512);
    v("row_alignment", row_alignment);
    v("estimate_disparity_offset", estimate_disparity_offset);
    v("disparity_offset_sigma_px", disparity_offset_sigma_px, 0.01, 10.0);
    v("disparity_offset_drift_px", disparity_offset_drift_px, 0.0, 1.0);
    v("disparity_jitter_px", disparity_jitter_px, 0.0, 5.0);
    v("principal_point_sigma_px", principal_point_sigma_px, 0.0, 50.0);
    v("scale_sigma", scale_sigma, 0.0, 0.5);
    v("disparity_tilt_sigma_px", disparity_tilt_sigma_px, 0.0, 10.0);
  }
};

/// How far the right image lies from where the calibration says, in columns: a point that an ideal
/// right camera sees in column x lies in column x + offset. So all measured disparities lack it,
/// and adding it to the right camera's cx cures that.
struct ColumnOffset {
  bool known = false;    ///< the camera has moved enough to tell
  double offset_px = 0;  ///< mean of the last frames: what cameras that shake come back to
  double sigma_px = 0;
  /// What to correct disparities by: the offset, in steps. It follows when it is more than 0.25 px
  /// and 3 sigma away, because every step costs the user of it something. 0 until the offset is
  /// known.
  double correction_px = 0;
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
  /// The part of the motion's covariance that is the same in all frames; see PathCovariance.
  CommonErrors common_errors = CommonErrors::Zero();
  bool swapped = false;          ///< lost, because the left image shows what the right camera sees
  int frames = 1;                ///< how many frames back `motion` starts: 1 is the previous one
  int features = 0;              ///< corners followed from there in both cameras
  int inliers = 0;               ///< those that agree with the motion
  double residual_px = 0;        ///< root mean square reprojection error of the inliers
  RowOffsetModel row_alignment;  ///< the vertical offset that the features' stereo matches showed
  /// To be added to measured disparities of this frame, and its standard deviation; 0 if switched
  /// off. Its change from frame to frame is known far better than its value.
  double disparity_offset_px = 0, disparity_offset_sigma_px = 0;
  ColumnOffset column_offset;  ///< what stays of that; unknown if switched off
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
  /// @param R_cam_prev  what another sensor says of the rotation since the frame before: takes
  ///   directions of that frame's left camera to this one's. Tried where few features agree, taken
  ///   where more agree with it: a wrong one costs time alone. No rotation, e.g. NaN: unused.
  /// @throws std::invalid_argument where sizes differ from rig.size.
  EgoMotionEstimate estimate(const cv::Mat1b& left, const cv::Mat1b& right, const StereoRig& rig,
                             const cv::Mat1b& moving_mask = {},
                             const std::optional<Eigen::Matrix3d>& R_cam_prev = {});
  /// Other parameters from the next frame on. What is known of the past is kept; switching
  /// estimate_disparity_offset forgets the past frames.
  /// @throws std::invalid_argument for parameters outside their limits; nothing has changed then.
  void setParams(const EgoMotionParams& params);
  /// Forgets the past frames. The estimated disparity offset, which belongs to the rig, stays.
  void reset();

 private:
  friend struct EgoMotionFault;
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace predictive_stereo
