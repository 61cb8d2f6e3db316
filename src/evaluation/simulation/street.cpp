#include "evaluation/simulation/street.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "parallel/tasks.h"
#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {
namespace {

using namespace simulation;

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
  Isometry3d T_body_cam(Eigen::AngleAxisd(camera.down_rad, Vector3d::UnitY()).toRotationMatrix() *
                        bodyFromOptical());
  T_body_cam.translation().z() = camera.up_m;
  return T_body_cam;
}

// Sets `occluded` and `truncated` by the outline without occlusion, also beyond the image borders.
// @param parts  its primitives.
void setHiddenShares(const RayGrid& grid, const std::vector<int>& parts, const cv::Mat1w& moving_id,
                     StreetMover& mover) {
  Eigen::AlignedBox2f bounds;
  for (const int part : parts) bounds.extend(grid.boundsOf(part));
  const Vector2f size(moving_id.cols, moving_id.rows);
  bounds.clamp(Eigen::AlignedBox2f(-size, 2 * size));
  const int right = cvFloor(bounds.max().x()), bottom = cvFloor(bounds.max().y());
  const cv::Rect image(cv::Point(), moving_id.size());
  // For the shares, every few pixels of large outlines are enough.
  const int step = std::max(1, static_cast<int>(std::sqrt(bounds.volume() / 20000.0)));
  int inside = 0, all = 0, visible = 0;
  for (int y = cvCeil(bounds.min().y()); y <= bottom; y += step) {
    for (int x = cvCeil(bounds.min().x()); x <= right; x += step) {
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

// The view for which the town is built.
View viewFrom(const Isometry3d& T_world_cam, const StereoRig& rig) {
  View view;
  view.position_m = T_world_cam.translation();
  view.forward = T_world_cam.linear().col(2).head<2>().normalized();
  const double reach = std::max(rig.cx_left_px, rig.size.width - rig.cx_left_px) + 40;
  view.tan_half_angle = reach / rig.fx_px;
  // Seen from above, the view of a pitched or rolled camera is wider, up to all directions.
  for (const double x : {0, rig.size.width})
    for (const double y : {0, rig.size.height}) {
      const Vector3d ray((x - rig.cx_left_px) / rig.fx_px, (y - rig.cy_px) / rig.fy_px, 1);
      const Vector2d seen = (T_world_cam.linear() * ray).head<2>();
      const double ahead = std::max(view.forward.dot(seen), 1e-3);
      const double aside = view.forward.x() * seen.y() - view.forward.y() * seen.x();
      view.tan_half_angle = std::max(view.tan_half_angle, std::abs(aside) / ahead);
    }
  return view;
}

}  // namespace

Street::Street(const StreetParams& params) : Street(params, sceneByName(params.scene)) {}

Street::Street(const StreetParams& params, const Scene& scene)
    : params_(withSceneDefaults(params, scene.camera)),
      scene_(scene),
      rig_(rigOf(params_, scene.camera)),
      T_body_cam_(mountOf(scene.camera)) {
  const double duration_s = exposureTimeOf(frames()) + 1;
  path_ = makePath(scene, duration_s, seed(1));
  movers_ = makeTraffic(scene.traffic, *path_, scene.camera.body_m, duration_s, seed(2));
}

uint32_t Street::seed(uint32_t use) const {
  return hashOf(static_cast<uint32_t>(params_.seed), use);
}

double Street::stampOf(int index) const {
  const int every = scene_.sensor.drop_every;
  const int lost = every > 1 ? index / (every - 1) : 0;
  return (index + lost) / params_.rate_hz;
}

double Street::exposureTimeOf(int index) const {
  const int every = scene_.sensor.duplicate_every;
  return stampOf(every > 1 && index % every == every - 1 ? index - 1 : index);
}

double Street::rightRowOffset(double x, double y) const {
  const double u = 2 * x / rig_.size.width - 1, v = 2 * y / rig_.size.height - 1;
  // Largest in the lower left corner (u = -1, v = 1): 1.
  const double shape = 0.1 - 0.15 * u + 0.15 * v + 0.05 * u * u - 0.55 * u * v;
  return scene_.sensor.row_offset_px * shape;
}

float Street::alignedRow(int x, int y) const {
  double row = y;
  for (int i = 0; i < 6; ++i) row = y - rightRowOffset(x, row);
  return static_cast<float>(row);
}

Primitives Street::primitivesAt(double time_s) const {
  const View view = viewFrom(poseAt(time_s), rig_);
  Primitives primitives;
  if (scene_.site == Site::kTown)
    addTown(scene_, seed(4), view, primitives);
  else if (scene_.site == Site::kHall)
    addHall(seed(4), primitives);
  else
    addCorridor(seed(4), primitives);
  for (const Mover& mover : movers_) {
    if (time_s < mover.from_s || time_s > mover.until_s) continue;
    const Place place = mover.placeAt(time_s, *path_);
    const Vector2d at = place.position_m.head<2>();
    if (scene_.site == Site::kTown && (view.distance(at) > 200 || !view.reaches(at, 8))) continue;
    addThing(mover.kind, mover.seed, place, mover.strideAt(time_s), mover.id, primitives);
  }
  return primitives;
}

void Street::fillTruth(const RayGrid& left, const HitImage& hits, StreetFrame& frame) const {
  frame.disparity_px.create(rig_.size);
  frame.moving_id.create(rig_.size);
  std::vector<bool> moves = {false};  // by the number of the object; they count from 1
  for (const Mover& mover : movers_)
    moves.push_back(mover.velocityAt(exposureTimeOf(frame.index), *path_).norm() >
                    kMovingSpeed_mps);
  const auto scale = static_cast<float>(rig_.disparityTimesDepth());
  parallelForEach(rig_.size.height, [&](int y) {
    for (int x = 0; x < rig_.size.width; ++x) {
      const Hit& hit = hits.at(x, y);
      frame.disparity_px(y, x) = hit.sky() ? 0.0f : scale / hit.t;
      const int object = hit.sky() ? 0 : left.primitive(hit.primitive).object;
      frame.moving_id(y, x) = static_cast<ushort>(moves[static_cast<size_t>(object)] ? object : 0);
    }
  });
}

void Street::fillMovers(const RayGrid& left, const HitImage& hits, StreetFrame& frame) const {
  const double time_s = exposureTimeOf(frame.index);
  std::map<int, StreetMover> seen;
  std::map<int, std::vector<int>> primitives_of;
  for (int y = 0; y < rig_.size.height; ++y) {
    for (int x = 0; x < rig_.size.width; ++x) {
      const int id = frame.moving_id(y, x);
      if (id == 0) continue;
      StreetMover& mover = seen[id];
      mover.box_px |= cv::Rect(x, y, 1, 1);
      mover.distance_m = std::min<double>(mover.distance_m, hits.at(x, y).t);
    }
  }
  for (int i = 0; i < left.count(); ++i) primitives_of[left.primitive(i).object].push_back(i);
  const Isometry3d T_cam_world = frame.T_world_cam.inverse();
  for (const Mover& mover : movers_) {
    const auto found = seen.find(mover.id);
    if (found == seen.end()) continue;
    StreetMover& out = found->second;
    out.id = mover.id;
    out.kind = kKindNames[static_cast<size_t>(mover.kind)];
    const Place place = mover.placeAt(time_s, *path_);
    const Vector3d size_m = sizeOf(mover.kind, mover.seed);
    out.velocity_mps = mover.velocityAt(time_s, *path_);
    const Eigen::Matrix3d axes =
        T_cam_world.linear() *
        Eigen::AngleAxisd(place.heading_rad, Vector3d::UnitZ()).toRotationMatrix();
    out.centre_m = T_cam_world * (place.position_m + Vector3d(0, 0, 0.5 * size_m.z()));
    out.extent_m = axes.cwiseAbs() * size_m;
    setHiddenShares(left, primitives_of.at(mover.id), frame.moving_id, out);
    frame.movers.push_back(out);
  }
}

StreetFrame Street::render(int index) const {
  if (index < 0 || index >= frames())
    throw std::invalid_argument("index = " + std::to_string(index) +
                                ": must be a frame of this street, 0 to " +
                                std::to_string(frames() - 1));
  const double time_s = exposureTimeOf(index);
  StreetFrame frame;
  frame.index = index;
  frame.stamp_s = stampOf(index);
  const Sensor& sensor = scene_.sensor;
  const RowOfPixel same_row = [](int, int y) { return static_cast<float>(y); };
  const RowOfPixel right_row =
      sensor.row_offset_px == 0 ? same_row : [this](int x, int y) { return alignedRow(x, y); };
  // The shutter is open around the stamp.
  const int samples = sensor.exposure_time_s > 0 ? 5 : 1;
  cv::Mat1f left_radiance = cv::Mat1f::zeros(rig_.size), right_radiance = left_radiance.clone();
  for (int i = 0; i < samples; ++i) {
    // The middle sample, which has the ground truth, is the last one.
    const int step = (i + samples / 2 + 1) % samples - samples / 2;
    const double at_s = time_s + sensor.exposure_time_s * step / samples;
    const Primitives primitives = primitivesAt(at_s);
    const Isometry3d pose = poseAt(at_s);
    const RayGrid left(primitives, pose, rig_, rig_.cx_left_px);
    const RayGrid right(primitives, pose * Eigen::Translation3d(rig_.baseline_m, 0, 0), rig_,
                        rig_.cx_right_px);
    const Shadows shadows(primitives, scene_.look.to_sun, pose.translation());
    const Light light{scene_.look, shadows, seed(5)};
    const HitImage left_hits = addRadiance(left, light, same_row, left_radiance);
    addRadiance(right, light, right_row, right_radiance);
    if (step != 0) continue;
    frame.T_world_cam = pose;
    fillTruth(left, left_hits, frame);
    fillMovers(left, left_hits, frame);
  }
  const double gain =
      255 * sensor.exposure / samples *
      (1 + sensor.exposure_swing * std::sin(2 * kPi * time_s / sensor.exposure_period_s));
  const uint32_t noise_seed = hashOf(static_cast<uint32_t>(params_.seed), 3,
                                     static_cast<uint32_t>(std::lround(time_s * 1e4)));
  expose(left_radiance, sensor, gain, 0, hashOf(noise_seed, 1), frame.left);
  expose(right_radiance, sensor, gain * sensor.right_gain, sensor.right_offset,
         hashOf(noise_seed, 2), frame.right);
  return frame;
}

}  // namespace predictive_stereo
