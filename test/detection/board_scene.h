/// Textured boards before a wall, rendered with their exact disparities.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "predictive_stereo/moving_objects.h"

namespace predictive_stereo {

/// A smooth random texture of some grey values.
class Texture {
 public:
  Texture(uint64_t seed, int darkest, int brightest, double grain_m)
      : grey_(64, 64), grain_m_(grain_m) {
    cv::RNG(seed).fill(grey_, cv::RNG::UNIFORM, darkest, brightest);
  }
  double greyAt(double x_m, double y_m) const {
    const double x = x_m / grain_m_, y = y_m / grain_m_;
    const double u = std::floor(x), v = std::floor(y), a = x - u, b = y - v;
    return (1 - b) * ((1 - a) * at(u, v) + a * at(u + 1, v)) +
           b * ((1 - a) * at(u, v + 1) + a * at(u + 1, v + 1));
  }

 private:
  double at(double u, double v) const { return grey_(int(v) & 63, int(u) & 63); }
  cv::Mat1d grey_;
  double grain_m_;
};

/// An upright rectangle in the odom frame, which is level; its texture moves with it.
struct Board {
  double left_m, top_m, width_m, height_m, depth_m;
  Texture texture{1, 140, 250, 0.3};
};

inline Board wallAt(double depth_m) {
  return {-200, -200, 400, 400, depth_m, Texture(2, 20, 110, 0.07 * depth_m)};
}

struct BoardScene {
  std::vector<Board> boards;
  double ground_m = 1000;  ///< of a level ground below the origin of the odom frame
};

struct BoardView {
  DetectionInput input;
  cv::Mat1b half_image;
};

inline StereoRig boardRig() {
  StereoRig rig;
  rig.size = {320, 240};
  rig.fx_px = rig.fy_px = 300;
  rig.cx_left_px = rig.cx_right_px = 160;
  rig.cy_px = 120;
  rig.baseline_m = 0.3;
  return rig;
}

/// Disparity and grey value at a pixel.
inline void seeBoards(const BoardScene& scene, const StereoRig& rig,
                      const Eigen::Isometry3d& T_odom_cam, cv::Point pixel, float& disparity_px,
                      uchar& grey) {
  static const Texture ground_texture(3, 20, 110, 0.4);
  const Eigen::Vector3d centre = T_odom_cam.translation();
  const Eigen::Vector3d ray =
      T_odom_cam.linear() *
      Eigen::Vector3d((pixel.x - rig.cx_left_px) / rig.fx_px, (pixel.y - rig.cy_px) / rig.fy_px, 1);
  double nearest_m = std::numeric_limits<double>::infinity();
  disparity_px = -1;
  grey = 0;
  const auto see = [&](double depth_m, double brightness) {
    nearest_m = depth_m;
    disparity_px = static_cast<float>(rig.disparityTimesDepth() / depth_m);
    grey = cv::saturate_cast<uchar>(brightness);
  };
  if (ray.y() > 0) {
    const double depth_m = (scene.ground_m - centre.y()) / ray.y();
    const Eigen::Vector3d point = centre + depth_m * ray;
    if (depth_m < 50) see(depth_m, ground_texture.greyAt(point.x(), point.z()));
  }
  for (const Board& board : scene.boards) {
    const double depth_m = (board.depth_m - centre.z()) / ray.z();
    if (!(depth_m > 0 && depth_m < nearest_m)) continue;
    const Eigen::Vector3d point = centre + depth_m * ray;
    const double x = point.x() - board.left_m, y = point.y() - board.top_m;
    if (x >= 0 && y >= 0 && x < board.width_m && y < board.height_m)
      see(depth_m, board.texture.greyAt(x, y));
  }
}

inline BoardView viewOf(const BoardScene& scene, double stamp_s,
                        const Eigen::Isometry3d& T_odom_cam = Eigen::Isometry3d::Identity()) {
  BoardView view;
  DetectionInput& input = view.input;
  input.stamp_s = stamp_s;
  input.rig = boardRig();
  input.pose_state = PoseState::kKnown;
  input.T_odom_cam = T_odom_cam;
  input.motion_covariance = 1e-6 * Matrix6d::Identity();  // 1 mm, 1 mrad
  input.left.create(input.rig.size);
  input.measured_disparity_px.create(input.rig.size);
  input.measured_variance_px2 = cv::Mat1f(input.rig.size, 0.05f);
  for (int y = 0; y < input.left.rows; ++y)
    for (int x = 0; x < input.left.cols; ++x)
      seeBoards(scene, input.rig, T_odom_cam, {x, y}, input.measured_disparity_px(y, x),
                input.left(y, x));
  cv::resize(input.left, view.half_image, {}, 0.5, 0.5, cv::INTER_NEAREST);
  return view;
}

}  // namespace predictive_stereo
