#include "predictive_stereo/past.h"

#include <opencv2/core.hpp>

#include "imaging/size_check.h"

namespace predictive_stereo {

void Past::setRig(const DisparityRange& range, const StereoRig& rig) {
  const double step_px = rig.cx_right_px - rig_.cx_right_px;
  if (step_px != 0) addToDisparities(range, step_px, filters_);
  rig_ = rig;
}

std::optional<CameraMotion> Past::motionBy(const CameraMotion& motion, std::optional<Stamp> start) {
  if (!start) return {};
  if (start == stamp_) return motion;
  forget();
  return {};
}

void Past::link(bool motion_known, int max_missed_frames) {
  is_linked_ = motion_known || filters_.empty();
  unlinked_frames_ = is_linked_ ? 0 : unlinked_frames_ + 1;
  if (is_linked_ || unlinked_frames_ <= max_missed_frames) return;
  unlinked_frames_ = 0;
  is_linked_ = true;
}

void Past::carry(Stamp stamp) {
  if (is_linked_) stamp_ = stamp;
}

void Past::eraseMoving(const cv::Mat1b& mask) {
  if (mask.empty() || !isLastFrame()) return;
  requireSize("mask of moving objects", mask.size(), filters_.missed_frames.size(),
              "but the images are");
  cv::bitwise_or(filters_.missed_frames, mask, filters_.missed_frames);
}

void Past::forget() {
  filters_ = DisparityState();
  stamp_.reset();
  unlinked_frames_ = 0;
}

}  // namespace predictive_stereo
