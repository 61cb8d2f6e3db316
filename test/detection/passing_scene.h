/// A wall beside a driving camera, with moving parts.
#pragma once

#include <opencv2/imgproc.hpp>
#include <vector>

#include "detection/motion_noise.h"
#include "frame_parts.h"

namespace predictive_stereo {

constexpr int kWidth = 400, kHeight = 160;
constexpr float kWall_px = 10, kStaticShift_px = 8, kShiftPerDisparity = 0.8f;

/// A wall with a noise texture, parallel to the image plane. The camera moves to the right, and
/// parts of the wall move on their own.
struct Passing : FrameParts {
  Passing() : now(kHeight, kWidth), before(kHeight, kWidth) {
    range = {0, 64};
    rig.size = {kWidth, kHeight};
    rig.fx_px = rig.fy_px = 300;
    rig.cx_left_px = rig.cx_right_px = kWidth / 2;
    rig.cy_px = kHeight / 2;
    rig.baseline_m = 0.5;
    T_prev_cam.translation().x() = kShiftPerDisparity * rig.baseline_m;
    cv::RNG rng(7);
    rng.fill(now, cv::RNG::UNIFORM, 0, 256);
    cv::GaussianBlur(now, now, {7, 7}, 2);
    cv::normalize(now, now, 0, 255, cv::NORM_MINMAX);
    shiftInto(cv::Rect(0, 0, kWidth, kHeight), kStaticShift_px);
    disparity = cv::Mat1f(kHeight, kWidth, kWall_px);
    variance = cv::Mat1f(kHeight, kWidth, 0.1f);
    disparity.copyTo(previous.disparity_px);
  }
  void shiftInto(cv::Rect part, float shift_px) {
    const int shift = static_cast<int>(shift_px);
    part.width = std::min(part.width, kWidth - shift - part.x);
    now(part).copyTo(before(part + cv::Point(shift, 0)));
  }
  /// Moves a part: in the previous image it was `by_px` to the right of its static position.
  void move(const cv::Rect& part, float by_px) { shiftInto(part, kStaticShift_px + by_px); }
  PastView view() {
    input.rig = rig;
    input.measured_disparity_px = disparity;
    input.measured_variance_px2 = variance;
    current.pyramid.build(now, 4);
    previous.pyramid.build(before, 4);
    obstacles.standing = cv::Mat1b(frame.lattice(), uchar{255});
    cells.setFrame(range, disparity, variance);
    past = {&previous, T_prev_cam, motion_covariance, kSeconds};
    return frame.since(past);
  }
  static constexpr double kSeconds = 0.1;
  StereoRig rig;
  Eigen::Isometry3d T_prev_cam = Eigen::Isometry3d::Identity();
  Matrix6d motion_covariance = toldCovariance(Matrix6d::Zero());
  cv::Mat1b now, before;
  cv::Mat1f disparity, variance;
  RememberedFrame previous;
  PastFrame past;
};

inline std::vector<cv::Point> pointsIn(const cv::Rect& part) {
  std::vector<cv::Point> points;
  for (int y = part.y; y < part.br().y; y += 8)
    for (int x = part.x; x < part.br().x; x += 8) points.emplace_back(x, y);
  return points;
}

const cv::Rect kAll(24, 24, 320, 112), kMover(160, 48, 96, 64);
// Inside the moving part, more than a patch from its border, where it occludes earlier background.
const cv::Rect kWithin(192, 56, 56, 48);

}  // namespace predictive_stereo
