#include "detection/frame_history.h"

#include <algorithm>
#include <cmath>

#include "detection/constants.h"
#include "detection/motion_noise.h"
#include "predictive_stereo/prediction.h"
#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {
namespace {

constexpr int kPyramidLevels = 4;

}  // namespace

void FrameHistory::remember(const DetectionInput& input) {
  continueMotions(input);
  const auto end = secondLastStays() ? frames_.end() : frames_.begin() + 2;
  std::rotate(frames_.begin(), end - 1, end);
  RememberedFrame& current = frames_[0];
  current.stamp_s = input.stamp_s;
  current.pose_state = input.pose_state;
  current.follows = !isUnseen(input.motion_covariance);
  current.T_odom_cam = input.T_odom_cam;
  current.motion_since = PathCovariance();
  current.pyramid.build(input.left, kPyramidLevels);
  input.measured_disparity_px.copyTo(current.disparity_px);
}

bool FrameHistory::isShownAgain(const DetectionInput& input) const {
  const RememberedFrame& current = frames_[0];
  const double apart_s = input.stamp_s - current.stamp_s;
  const bool follows = input.pose_state == PoseState::kKnown &&
                       !isUnseen(input.motion_covariance) && apart_s > 0 && apart_s < kLongestGap_s;
  if (current.empty() || current.pose_state != PoseState::kKnown || !follows) return false;
  const cv::Mat1b& image = current.pyramid.level(0);
  if (image.size() != input.left.size()) return false;
  for (int y = 0; y < image.rows; ++y)
    if (!std::equal(image[y], image[y] + image.cols, input.left[y])) return false;
  return true;
}

// Before a new frame is added: whether the frame before the current one is far enough from those
// before it. It also stays where nothing before it can be compared: there past() ends.
bool FrameHistory::secondLastStays() const {
  const RememberedFrame &second_last = frames_[1], &before = frames_[2];
  return before.empty() || !second_last.follows || second_last.pose_state != PoseState::kKnown ||
         !(std::abs(second_last.stamp_s - before.stamp_s) < kLeastApart_s);
}

// Frames before one without a known pose are not compared any more: see past().
void FrameHistory::continueMotions(const DetectionInput& input) {
  const CameraMotion motion{relative(input.T_odom_cam, frames_[0].T_odom_cam),
                            toldCovariance(input.motion_covariance)};
  for (RememberedFrame& frame : frames_) frame.motion_since.add(motion, CommonErrors::Zero());
}

void FrameHistory::addToDisparities(const DisparityRange& range, double step_px) {
  for (RememberedFrame& frame : frames_)
    if (!frame.empty()) predictive_stereo::addToDisparities(range, step_px, frame.disparity_px);
}

std::vector<PastFrame> FrameHistory::past() const {
  std::vector<PastFrame> past;
  const RememberedFrame& current = frames_[0];
  for (size_t k = 1; k < frames_.size(); ++k) {
    const RememberedFrame& frame = frames_[k];
    if (frame.empty() || current.pose_state != PoseState::kKnown ||
        frame.pose_state != PoseState::kKnown || !frames_[k - 1].follows ||
        !(frame.stamp_s < frames_[k - 1].stamp_s))
      break;
    past.push_back({&frame, relative(frame.T_odom_cam, current.T_odom_cam),
                    frame.motion_since.covariance(), current.stamp_s - frame.stamp_s});
  }
  return past;
}

void FrameHistory::reset() {
  for (RememberedFrame& frame : frames_) frame = RememberedFrame();
}

bool PoseCheck::contradictsMost(double contradicting) { return contradicting > kMostContradicting; }

bool PoseCheck::agreesWithMotion(double contradicting) {
  const bool odd = contradictsMost(contradicting) ||
                   (usual_ && contradicting > *usual_ + kSuddenlyContradicting);
  if (odd && odd_frames_ < kMostOddFrames) {
    ++odd_frames_;
    return false;
  }
  odd_frames_ = 0;
  usual_ = contradicting;
  return true;
}

}  // namespace predictive_stereo
