/// Synthetic stereo sequences with exact ground truth for every frame. Besides streets there are
/// other sites (a hall, a corridor) and other camera carriers than cars (a drone, a robot, a hand).
///
/// World: x and y on the ground, z up [m]. Frames depend only on the parameters and on their index:
/// they can be rendered in any order, by any number of threads, with the same result.
#pragma once

#include <Eigen/Geometry>
#include <limits>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "evaluation/simulation/camera.h"
#include "evaluation/simulation/traffic.h"
#include "evaluation/simulation/worlds.h"
#include "predictive_stereo/params.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

struct StreetParams {
  std::string scene = "street";  ///< see simulation::scenes()
  int seed = 1;                  ///< another seed gives another town with other traffic
  int frames = 150;
  /// The camera; 0: default of the scene, mostly KITTI's with 1242 x 375 px and 10 Hz.
  int width = 0;   ///< [px]; focal length and principal point scale with it
  int height = 0;  ///< [px]
  double rate_hz = 0;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("scene", scene);
    v("seed", seed, 0, 1000000000);
    v("frames", frames, 1, 100000);
    v("width", width, 32, 4096);
    v("height", height, 32, 4096);
    v("rate_hz", rate_hz, 0.1, 1000.0);
  }
};

/// An object that moves faster than kMovingSpeed_mps, with at least one visible pixel.
struct StreetMover {
  int id = 0;                ///< 1.., the same in all frames
  std::string kind;          ///< car, van, truck, bus, person, cyclist
  cv::Rect box_px;           ///< of its visible pixels in the left image
  Eigen::Vector3d centre_m;  ///< of its 3-D box, in the left camera's optical frame
  Eigen::Vector3d extent_m;  ///< of its 3-D box along the axes of the left camera's optical frame
  Eigen::Vector3d velocity_mps;  ///< in the world
  /// Smallest depth Z of a visible pixel.
  double distance_m = std::numeric_limits<double>::infinity();
  double occluded = 0;   ///< occluded share of its outline inside the image, 0..1
  double truncated = 0;  ///< share of its outline outside the image, 0..1; outlines are
                         ///< followed up to one image size beyond the borders

  /// Share of its outline that is inside the image and not occluded.
  double visibleShare() const { return (1 - occluded) * (1 - truncated); }
};

struct StreetFrame {
  int index = 0;
  double stamp_s = 0;
  cv::Mat1b left, right;
  /// True disparity [px] at the pixel centres of the left image, as StereoRig defines disparity; 0:
  /// the sky, infinitely far away. It is that of the surface which the ray through the centre hits,
  /// also at edges, where the brightness is a mixture of two surfaces.
  cv::Mat1f disparity_px;
  cv::Mat1w moving_id;            ///< StreetMover::id, 0: static
  Eigen::Isometry3d T_world_cam;  ///< pose of the left camera's optical frame
  std::vector<StreetMover> movers;
};

class Street {
 public:
  static constexpr double kMovingSpeed_mps = 0.3;

  /// @throws std::invalid_argument for an unknown scene (it lists the known ones) or a value
  ///   outside its range.
  explicit Street(const StreetParams& params);
  /// Renders the given scene; params.scene is not used.
  Street(const StreetParams& params, const simulation::Scene& scene);

  const StereoRig& rig() const { return rig_; }
  int frames() const { return params_.frames; }

  /// Images and ground truth of one frame.
  /// @param index  0 .. frames() - 1.
  StreetFrame render(int index) const;

  /// Ground truth without images. A frame that repeats the previous one was exposed before its
  /// stamp.
  double stampOf(int index) const;
  double exposureTimeOf(int index) const;
  Eigen::Isometry3d poseOf(int index) const { return poseAt(exposureTimeOf(index)); }
  /// Pose of the left camera's optical frame in the world, from time 0 to that of the last frame.
  Eigen::Isometry3d poseAt(double time_s) const { return path_->bodyAt(time_s) * T_body_cam_; }
  /// Pose of that frame in the frame of the body that carries the camera (x ahead, z up). A
  /// vehicle's origin is on the road below the camera. The pose is constant: a vehicle that sways
  /// tilts as a whole.
  const Eigen::Isometry3d& cameraMount() const { return T_body_cam_; }

  /// Vertical misalignment of the right camera [px]: a point that an ideal right camera sees at
  /// (x, y) appears at (x, y + rightRowOffset(x, y)) in the right image. It is quadratic in x and y
  /// with a dominant x*y term, as in KITTI; 0 in most scenes.
  double rightRowOffset(double x_right_px, double y_px) const;

 private:
  using HitImage = simulation::HitImage;
  using RayGrid = simulation::RayGrid;

  /// Each use of random numbers has its own seed.
  uint32_t seed(uint32_t use) const;
  /// Inverse of rightRowOffset: row of an aligned image that corresponds to a pixel of the right
  /// image.
  float alignedRow(int x, int y) const;
  simulation::Primitives primitivesAt(double time_s) const;
  void fillTruth(const RayGrid& left, const HitImage& hits, StreetFrame& frame) const;
  void fillMovers(const RayGrid& left, const HitImage& hits, StreetFrame& frame) const;

  StreetParams params_;
  simulation::Scene scene_;
  StereoRig rig_;
  Eigen::Isometry3d T_body_cam_;
  std::shared_ptr<const simulation::Path> path_;
  std::vector<simulation::Mover> movers_;
};

}  // namespace predictive_stereo
