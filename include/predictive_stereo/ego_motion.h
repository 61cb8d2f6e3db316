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

  template <class Visitor>
  void visit(Visitor&& v) {
    v("features", features, 50, 5000);
    v("max_disparity_px", max_disparity_px, 16, 512);
    v("row_alignment", row_alignment);
  }
};

enum class EgoMotionStatus {
  kFirstFrame,  ///< nothing to compare with: after construction, a reset or a changed size
  kTracked,
  kLost,  ///< too few features agree; the motion is identity and its covariance 9999
};

struct EgoMotionEstimate {
  EgoMotionStatus status = EgoMotionStatus::kFirstFrame;
  CameraMotion motion;         ///< from the last frame that was not lost to this one
  int features = 0;            ///< corners followed from the previous frame in both cameras
  int inliers = 0;             ///< those that agree with the motion
  double residual_px = 0;      ///< root mean square reprojection error of the inliers
  RowAlignment row_alignment;  ///< the vertical offset that the features' stereo matches showed
};

/// Frame-to-frame stereo odometry: corners, tracks, depth by a search along the row, RANSAC, robust
/// Gauss-Newton on both cameras' reprojection errors. Deterministic for a given input, whatever the
/// number of threads.
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
  /// Forgets the previous frame.
  void reset();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace predictive_stereo
