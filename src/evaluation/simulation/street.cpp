#include "evaluation/simulation/street.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include "evaluation/simulation/camera.h"
#include "evaluation/simulation/indoor.h"
#include "evaluation/simulation/path.h"
#include "evaluation/simulation/town.h"
#include "evaluation/simulation/traffic.h"
#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

using namespace simulation;
using Eigen::Isometry3d;
using Eigen::Vector3d;

// Replaces zeros by the defaults of the scene.
StreetParams withSceneDefaults(StreetParams params, const Camera& camera) {
  if (params.width == 0) params.width = camera.width;
  if (params.height == 0) params.height = camera.height;
  if (params.rate_hz == 0) params.rate_hz = camera.rate_hz;
  validate(params);
  return params;
}

StereoRig rigOf(const StreetParams& params, const Camera& camera) {
  StereoRig rig;
  rig.size = {params.width, params.height};
  const double scale = params.width / static_cast<double>(camera.width);
  rig.fx_px = rig.fy_px = camera.focal_px * scale;
  rig.cx_left_px = rig.cx_right_px = (camera.cx_px + 0.5) * scale - 0.5;
  rig.cy_px = camera.cy_share * params.height - 0.5;
  rig.baseline_m = camera.baseline_m;
  return rig;
}

Isometry3d mountOf(const Camera& camera) {
  Eigen::Matrix3d R_body_cam;  // axes of a level camera
  R_body_cam << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  Isometry3d T_body_cam = Isometry3d::Identity();
  T_body_cam.linear() =
      Eigen::AngleAxisd(camera.down_rad, Vector3d::UnitY()).toRotationMatrix() * R_body_cam;
  T_body_cam.translation().z() = camera.up_m;
  return T_body_cam;
}

// Sets `occluded` and `truncated` by the outline without occlusion, also beyond the image borders.
// @param parts  its primitives.
void setHiddenShares(const RayGrid& grid, const std::vector<int>& parts, const cv::Mat1w& moving_id,
                     StreetMover& mover) {
  const auto width = static_cast<float>(moving_id.cols),
             height = static_cast<float>(moving_id.rows);
  cv::Rect2f bounds;
  for (const int part : parts) bounds |= grid.boundsOf(part);
  bounds &= cv::Rect2f(-width, -height, 3 * width, 3 * height);
  const int right = cvFloor(bounds.x + bounds.width), bottom = cvFloor(bounds.y + bounds.height);
  const cv::Rect image(cv::Point(), moving_id.size());
  // For the shares, every few pixels of large outlines are enough.
  const int step = std::max(1, static_cast<int>(std::sqrt(bounds.area() / 20000.0)));
  int inside = 0, all = 0, visible = 0;
  for (int y = cvCeil(bounds.y); y <= bottom; y += step) {
    for (int x = cvCeil(bounds.x); x <= right; x += step) {
      const bool within = image.contains({x, y}), seen = within && moving_id(y, x) == mover.id;
      const bool covered = seen || std::any_of(parts.begin(), parts.end(), [&](int part) {
                             return grid.meets(part, static_cast<float>(x), static_cast<float>(y));
                           });
      visible += seen;
      all += covered;
      inside += covered && within;
    }
  }
  mover.occluded = inside > 0 ? 1.0 - static_cast<double>(visible) / inside : 0.0;
  mover.truncated = all > 0 ? 1.0 - static_cast<double>(inside) / all : 0.0;
}

}  // namespace

struct Street::World {
  StreetParams params;
  Scene scene;
  StereoRig rig;
  Isometry3d T_body_cam;
  double duration_s;
  std::unique_ptr<const Path> path;
  std::vector<Mover> movers;

  World(const StreetParams& p, const Scene& s)
      : params(withSceneDefaults(p, s.camera)),
        scene(s),
        rig(rigOf(params, scene.camera)),
        T_body_cam(mountOf(scene.camera)),
        duration_s(exposureTime(params.frames) + 1),
        path(makePath(scene, duration_s, hashOf(seed(), 1))),
        movers(makeTraffic(scene.traffic, *path, scene.camera.body_m, duration_s,
                           hashOf(seed(), 2))) {}

  uint32_t seed() const { return static_cast<uint32_t>(params.seed); }

  Isometry3d cameraAt(double time_s) const { return path->bodyAt(time_s) * T_body_cam; }

  double stamp(int index) const {
    const int every = scene.sensor.drop_every;
    const int lost = every > 1 ? index / (every - 1) : 0;
    return (index + lost) / params.rate_hz;
  }
  // A frame that repeats the previous image was exposed before its stamp.
  double exposureTime(int index) const {
    const int every = scene.sensor.duplicate_every;
    return stamp(every > 1 && index % every == every - 1 ? index - 1 : index);
  }
  uint32_t exposureSeed(int index) const {
    return hashOf(seed(), 3, static_cast<uint32_t>(std::lround(exposureTime(index) * 1e4)));
  }

  double rowOffset(double x, double y) const {
    const double u = 2 * x / rig.size.width - 1, v = 2 * y / rig.size.height - 1;
    // Largest in the lower left corner (u = -1, v = 1): 1.
    const double shape = 0.1 - 0.15 * u + 0.15 * v + 0.05 * u * u - 0.55 * u * v;
    return scene.sensor.row_offset_px * shape;
  }
  // Inverse of rowOffset: row of the aligned image that corresponds to a pixel of the right image.
  float idealRow(int x, int y) const {
    double row = y;
    for (int i = 0; i < 6; ++i) row = y - rowOffset(x, row);
    return static_cast<float>(row);
  }

  // The view for which the town is built.
  View viewFrom(const Isometry3d& T_world_cam) const {
    View view;
    view.position_m = T_world_cam.translation();
    view.forward = T_world_cam.linear().col(2).head<2>().normalized();
    const double reach = std::max(rig.cx_left_px, rig.size.width - rig.cx_left_px) + 40;
    view.tan_half_angle = reach / rig.fx_px;
    view.all_around = scene.look.glossy_cars;
    // Seen from above, the view of a pitched or rolled camera is wider, up to all directions.
    for (const double x : {0, rig.size.width})
      for (const double y : {0, rig.size.height}) {
        const Vector3d ray((x - rig.cx_left_px) / rig.fx_px, (y - rig.cy_px) / rig.fy_px, 1);
        const Eigen::Vector2d seen = (T_world_cam.linear() * ray).head<2>();
        const double ahead = std::max(view.forward.dot(seen), 1e-3);
        const double aside = view.forward.x() * seen.y() - view.forward.y() * seen.x();
        view.tan_half_angle = std::max(view.tan_half_angle, std::abs(aside) / ahead);
      }
    return view;
  }

  Primitives primitivesAt(double time_s) const {
    const Isometry3d pose = cameraAt(time_s);
    const View view = viewFrom(pose);
    const uint32_t site_seed = hashOf(seed(), 4);
    Primitives primitives;
    if (scene.site == Site::kTown)
      addTown(scene, site_seed, view, primitives);
    else if (scene.site == Site::kHall)
      addHall(site_seed, primitives);
    else
      addCorridor(site_seed, primitives);
    for (const Mover& mover : movers) {
      if (time_s < mover.from_s || time_s > mover.until_s) continue;
      const Place place = mover.placeAt(time_s, *path);
      const Eigen::Vector2d at = place.position_m.head<2>();
      if (scene.site == Site::kTown && (view.distance(at) > 200 || !view.reaches(at, 8))) continue;
      addThing(mover.kind, mover.seed, place, mover.strideAt(time_s), mover.id, primitives);
    }
    if (scene.look.glossy_cars) makeGlossy(primitives);
    return primitives;
  }

  Isometry3d rightPose(const Isometry3d& T_world_cam) const {
    return T_world_cam * Eigen::Translation3d(rig.baseline_m, 0, 0);
  }

  void renderImages(int index, StreetFrame& frame) const;
  void fillTruth(const RayGrid& left, const HitImage& hits, const RayGrid& right,
                 StreetFrame& frame) const;
  void fillMovers(const RayGrid& left, const HitImage& hits, double time_s,
                  StreetFrame& frame) const;
};

void Street::World::fillTruth(const RayGrid& left, const HitImage& hits, const RayGrid& right,
                              StreetFrame& frame) const {
  frame.disparity_px.create(rig.size);
  frame.occluded.create(rig.size);
  frame.moving_id.create(rig.size);
  std::vector<bool> moves(1, false);
  for (const Mover& mover : movers) {
    moves.resize(static_cast<size_t>(mover.id) + 1, false);
    moves[static_cast<size_t>(mover.id)] =
        mover.velocityAt(exposureTime(frame.index), *path).norm() > kMovingSpeed_mps;
  }
  const auto columns_apart = static_cast<float>(rig.cx_left_px - rig.cx_right_px);
  const auto scale = static_cast<float>(rig.disparityTimesDepth());
  parallelFor(cv::Range(0, rig.size.height), [&](const cv::Range& rows) {
    for (int y = rows.start; y < rows.end; ++y) {
      for (int x = 0; x < rig.size.width; ++x) {
        const Hit& hit = hits.at(x, y);
        const float disparity = hit.sky() ? 0.0f : scale / hit.t;
        frame.disparity_px(y, x) = disparity;
        const float x_right = static_cast<float>(x) - disparity - columns_apart;
        const auto row = static_cast<float>(y);
        // The limit is slightly nearer than the point, which must not occlude itself.
        const bool hidden = x_right < -0.5f ||
                            x_right > static_cast<float>(rig.size.width) - 0.5f ||
                            !right.cast(x_right, row, hit.t * (1 - 1e-4f) - 2e-3f).sky();
        frame.occluded(y, x) = hidden ? 255 : 0;
        const int object = hit.sky() ? 0 : left.primitive(hit.primitive).object;
        frame.moving_id(y, x) =
            static_cast<ushort>(moves[static_cast<size_t>(object)] ? object : 0);
      }
    }
  });
}

void Street::World::fillMovers(const RayGrid& left, const HitImage& hits, double time_s,
                               StreetFrame& frame) const {
  std::map<int, StreetMover> seen;
  std::map<int, std::vector<int>> primitives_of;
  for (int y = 0; y < rig.size.height; ++y) {
    for (int x = 0; x < rig.size.width; ++x) {
      const int id = frame.moving_id(y, x);
      if (id == 0) continue;
      StreetMover& mover = seen[id];
      mover.box_px |= cv::Rect(x, y, 1, 1);
      mover.distance_m = std::min<double>(mover.distance_m, hits.at(x, y).t);
    }
  }
  for (int i = 0; i < left.count(); ++i) primitives_of[left.primitive(i).object].push_back(i);
  const Isometry3d T_cam_world = frame.T_world_cam.inverse();
  for (const Mover& mover : movers) {
    const auto found = seen.find(mover.id);
    if (found == seen.end()) continue;
    StreetMover& out = found->second;
    out.id = mover.id;
    out.kind = kKindNames[static_cast<size_t>(mover.kind)];
    const Place place = mover.placeAt(time_s, *path);
    const Vector3d size_m = sizeOf(mover.kind, mover.seed);
    out.velocity_mps = mover.velocityAt(time_s, *path);
    const Eigen::Matrix3d axes =
        T_cam_world.linear() *
        Eigen::AngleAxisd(place.heading_rad, Vector3d::UnitZ()).toRotationMatrix();
    out.centre_m = T_cam_world * (place.position_m + Vector3d(0, 0, 0.5 * size_m.z()));
    out.extent_m = axes.cwiseAbs() * size_m;
    setHiddenShares(left, primitives_of.at(mover.id), frame.moving_id, out);
    frame.movers.push_back(out);
  }
}

void Street::World::renderImages(int index, StreetFrame& frame) const {
  const double time_s = exposureTime(index);
  const Sensor& sensor = scene.sensor;
  const RowOfPixel same_row = [](int, int y) { return static_cast<float>(y); };
  const RowOfPixel right_row =
      sensor.row_offset_px == 0 ? same_row : [this](int x, int y) { return idealRow(x, y); };
  // The shutter is open around the stamp.
  const int samples = sensor.exposure_time_s > 0 ? 5 : 1;
  cv::Mat1f left_radiance = cv::Mat1f::zeros(rig.size), right_radiance = left_radiance.clone();
  for (int i = 0; i < samples; ++i) {
    // The middle sample, which has the ground truth, is the last one.
    const int step = (i + samples / 2 + 1) % samples - samples / 2;
    const double at_s = time_s + sensor.exposure_time_s * step / samples;
    const Primitives primitives = primitivesAt(at_s);
    const Isometry3d pose = cameraAt(at_s);
    const RayGrid left(primitives, pose, rig, rig.cx_left_px);
    const RayGrid right(primitives, rightPose(pose), rig, rig.cx_right_px);
    const RayMap around(primitives, scene.look.to_sun, pose.translation());
    const Light light{scene.look, around, hashOf(seed(), 5)};
    const HitImage left_hits = addRadiance(left, light, same_row, left_radiance);
    addRadiance(right, light, right_row, right_radiance);
    if (step != 0) continue;
    frame.T_world_cam = pose;
    fillTruth(left, left_hits, right, frame);
    fillMovers(left, left_hits, time_s, frame);
  }
  const double gain =
      255 * sensor.exposure / samples *
      (1 + sensor.exposure_swing * std::sin(2 * kPi * time_s / sensor.exposure_period_s));
  expose(left_radiance, sensor, gain, 0, hashOf(exposureSeed(index), 1), frame.left);
  expose(right_radiance, sensor, gain * sensor.right_gain, sensor.right_offset,
         hashOf(exposureSeed(index), 2), frame.right);
}

Street::Street(const StreetParams& params) : Street(params, sceneByName(params.scene)) {}
Street::Street(const StreetParams& params, const Scene& scene)
    : world_(std::make_shared<const World>(params, scene)) {}

const StereoRig& Street::rig() const { return world_->rig; }
int Street::frames() const { return world_->params.frames; }
double Street::stampOf(int index) const { return world_->stamp(index); }
double Street::exposureTimeOf(int index) const { return world_->exposureTime(index); }
Isometry3d Street::poseAt(double time_s) const { return world_->cameraAt(time_s); }
Isometry3d Street::cameraMount() const { return world_->T_body_cam; }
double Street::rightRowOffset(double x, double y) const { return world_->rowOffset(x, y); }

StreetFrame Street::render(int index) const {
  if (index < 0 || index >= frames())
    throw std::invalid_argument("index = " + std::to_string(index) +
                                ": must be a frame of this street, 0 to " +
                                std::to_string(frames() - 1));
  StreetFrame frame;
  frame.index = index;
  frame.stamp_s = world_->stamp(index);
  world_->renderImages(index, frame);
  return frame;
}

}  // namespace predictive_stereo
