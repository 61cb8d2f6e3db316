/// The camera's own motion between stereo pairs.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>

#include "predictive_stereo/disparity_motion.h"
#include "predictive_stereo/params.h"
#include "predictive_stereo/path_covariance.h"
#include "predictive_stereo/pose_state.h"
#include "predictive_stereo/row_alignment.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

struct EgoMotionParams {
  int features = 500;          ///< corners that are tracked from frame to frame
  int max_disparity_px = 128;  ///< nearer points are not used
  RowAlignmentParams row_alignment;
  /// Whether to estimate the disparity offset: a constant error of all measured disparities, as
  /// after a small turn of one camera. It is observable while the camera moves: near and far points
  /// then disagree on the distance moved. On KITTI it shortens the path by 0.7 %.
  bool estimate_disparity_offset = true;
  double disparity_offset_sigma_px = 1.0;   ///< standard deviation before the first frame
  double disparity_offset_drift_px = 0.02;  ///< standard deviation of its random walk, per frame
  /// Standard deviation of a disparity error that is the same in all pixels of a frame and
  /// independent from frame to frame: on a bumpy road the cameras shake against each other (on one
  /// KITTI drive by up to 0.8 px). 0: no such error.
  double disparity_jitter_px = 0.3;
  /// Standard deviations of the calibration, which limit the certainty of a path. All 0: perfect
  /// calibration, as in a simulation. An error of the principal point, divided by the focal length,
  /// turns the direction of motion.
  double principal_point_sigma_px = 2;
  double scale_sigma = 0.002;  ///< of baseline and focal length, relative
  /// Of a disparity error that grows from the image's centre to its borders. With it a camera that
  /// drives straight on appears to turn.
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

/// Horizontal offset of the right image from its calibration: a point that an ideal right camera
/// sees in column x is in column x + offset. All measured disparities are too small by it. Adding
/// it to the right camera's cx corrects them.
struct ColumnOffset {
  bool known = false;    ///< whether the camera has moved enough to estimate it
  double offset_px = 0;  ///< mean over the last frames, which averages the jitter
  double sigma_px = 0;   ///< standard deviation of offset_px
  /// The offset as it is to be added to disparities. It changes in steps, when the offset is more
  /// than 0.25 px and 3 sigma away: each step disturbs the stages that use it. 0 until the offset
  /// is known.
  double correction_px = 0;
};

/// The rig of the disparities that are corrected by this offset.
inline StereoRig corrected(StereoRig rig, const ColumnOffset& offset) {
  rig.cx_right_px += offset.correction_px;
  return rig;
}

struct EgoMotionEstimate {
  static constexpr int kMostFrames = 10;
  /// kKnown: `motion` was seen. kHeld: it was not, but frames before this one are kept to compare
  /// later ones with. kLost: none is kept, or there was none: after construction, a reset, another
  /// rig, or kMostFrames frames that were lost one after the other.
  PoseState state = PoseState::kLost;
  /// From the frame that is `frames` back to this one. That frame is the last one that was tracked,
  /// or a later one if the two have no view in common. Not seen: identity, with a covariance of
  /// 9999 times identity.
  CameraMotion motion;
  /// The part of the motion's covariance that is the same in all frames; see PathCovariance.
  CommonErrors common_errors = CommonErrors::Zero();
  bool swapped = false;          ///< not seen, as the left image is the right camera's
  int frames = 1;                ///< where `motion` starts: 1 is the previous frame; <= kMostFrames
  int features = 0;              ///< corners tracked from there and matched in both images
  int inliers = 0;               ///< those that agree with the motion
  double residual_px = 0;        ///< root mean square reprojection error of the inliers
  RowOffsetModel row_alignment;  ///< vertical offset, fitted to the features' stereo matches
  /// To be added to measured disparities of this frame, and its standard deviation; 0 if
  /// estimate_disparity_offset is off. Its change from frame to frame is far more certain than its
  /// value.
  double disparity_offset_px = 0, disparity_offset_sigma_px = 0;
  ColumnOffset column_offset;  ///< its lasting part; not known if estimate_disparity_offset is off
};

struct EgoMotionState;

/// Stereo odometry: corners, tracks, depth by a search along the row, RANSAC, robust Gauss-Newton
/// on both cameras' reprojection errors. It stands in for the paper's libviso2.
///
/// Motion is estimated against a reference frame: the previous frame; or an earlier one while the
/// camera stands still, which avoids drift, and after frames without features. The result depends
/// on the input only, not on the number of threads.
class EgoMotion {
 public:
  /// @throws std::invalid_argument if a parameter is outside its limits.
  explicit EgoMotion(const EgoMotionParams& params);
  ~EgoMotion();
  EgoMotion(EgoMotion&&) noexcept;
  EgoMotion& operator=(EgoMotion&&) noexcept;

  /// @param left, right  rectified 8-bit grey images of rig.size.
  /// @param rig  a change resets everything, including the disparity offset.
  /// @param ignored_mask  empty, or of rig.size: not 0 where features of earlier frames are
  ///   ignored. If it ignores all of them, later frames are not compared with this pair either.
  /// @param R_cam_prev  rotation since the previous frame from another sensor: maps directions of
  ///   the previous left camera to the current one. It is tried if few features agree on a motion,
  ///   and used if more agree with it: a wrong one only costs time. A matrix that is not a rotation
  ///   (e.g. NaN) is ignored.
  /// @param interval_s  [s] time since the previous frame, > 0: limits the change of velocity.
  ///   Infinite: not known.
  /// @throws std::invalid_argument if an image or the mask does not have rig.size.
  EgoMotionEstimate estimate(const cv::Mat1b& left, const cv::Mat1b& right, const StereoRig& rig,
                             const cv::Mat1b& ignored_mask = {},
                             const std::optional<Eigen::Matrix3d>& R_cam_prev = {},
                             double interval_s = std::numeric_limits<double>::infinity());
  /// Sets parameters for the next frame. The past frames are kept, unless estimate_disparity_offset
  /// changes.
  /// @throws std::invalid_argument if a parameter is outside its limits; the parameters are then
  ///   unchanged.
  void setParams(const EgoMotionParams& params);
  /// Forgets the past frames. The estimated disparity offset belongs to the rig and is kept.
  void reset();

 private:
  std::unique_ptr<EgoMotionState> state_;
};

}  // namespace predictive_stereo
