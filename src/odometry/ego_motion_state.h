#pragma once

#include <optional>
#include <vector>

#include "odometry/motion_choice.h"
#include "odometry/reference_frame.h"
#include "odometry/steady_offset.h"
#include "odometry/stereo_features.h"
#include "predictive_stereo/ego_motion.h"

namespace predictive_stereo {

/// What EgoMotion keeps from frame to frame, and its steps.
struct EgoMotionState {
  explicit EgoMotionState(const EgoMotionParams& p) : params(p), features(p) {
    validate(p, "ego_motion/");
    startOffset();
  }

  void setParams(const EgoMotionParams& p) {
    validate(p, "ego_motion/");
    const bool other_offset = p.estimate_disparity_offset != params.estimate_disparity_offset;
    params = p;
    features.setParams(p);
    if (!other_offset) return;
    reset();
    startOffset();
  }
  void startOffset() {
    offset = DisparityOffset();
    steady_offset = SteadyOffset();
    if (params.estimate_disparity_offset)
      offset.variance_px2 = params.disparity_offset_sigma_px * params.disparity_offset_sigma_px;
  }
  void reset() {
    references.clear();
    features.reset();
    usual = UsualMotion();
  }

  EgoMotionEstimate estimate(const cv::Mat1b& left, const cv::Mat1b& right, const StereoRig& rig,
                             const cv::Mat1b& ignored_mask,
                             const std::optional<Eigen::Matrix3d>& R_cam_prev, double interval_s);

  MotionChoice motionSince(const ReferenceFrame& reference, const cv::Mat1b& ignored_mask);
  void describeMotion(const PoseSolution& solution, const ReferenceFrame& reference,
                      EgoMotionEstimate& estimate) const;
  void describeOffset(EgoMotionEstimate& estimate) const;
  void chooseReference(const MotionChoice& choice, size_t used);
  PoseState chooseReferencesAfterLoss(bool unusable);
  ReferenceFrame makeReference(const MotionChoice& choice);
  void drift(DisparityOffset& some_offset) const;
  DisparityOffset offsetNotTracked() const;

  EgoMotionParams params;
  StereoFeatures features;  // of the current frame
  DisparityOffset offset;   // of the last frame that was tracked, with the drift since then
  SteadyOffset steady_offset;
  UsualMotion usual;
  // Reference frames for the next frame, best first: one, or two after a loss.
  std::vector<ReferenceFrame> references;
};

}  // namespace predictive_stereo
