/// Descriptions of the synthetic scenes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "evaluation/simulation/material.h"
#include "evaluation/simulation/models.h"

namespace predictive_stereo::simulation {

/// Kind of static world around the camera.
enum class Site : uint8_t {
  kTown,  ///< see worlds.h
  kHall,
  kCorridor,
};

/// The stereo camera, and the body that carries it.
struct Camera {
  int width = 1242, height = 375;  ///< [px]
  double rate_hz = 10;
  double focal_px = 721.5377;               ///< at this width, as cx_px
  double cx_px = 609.56, cy_share = 0.461;  ///< principal point; cy relative to the height
  double baseline_m = 0.54;
  double up_m = 1.65;                 ///< height of the camera above the body's origin
  double down_rad = 0.012;            ///< its downward pitch
  Vector3d body_m = {4.2, 1.8, 1.5};  ///< length, width, height
};

/// Drive of the body along the town's streets.
struct Drive {
  double start_m = -75;   ///< start x, on the street y = 0; junctions are at 0, 100, ...
  double cruise_mps = 8;  ///< 0: standing
  double brake_mps2 = 2.5;
  double stop_first_m = -1;  ///< distance to the first stop; negative: no stops
  double stop_every_m = 0;   ///< distance between further stops; 0: no further ones
  double stop_s = 2;         ///< duration of a stop
  std::string turns = "S";   ///< at the junctions: S straight, L left, R right; repeated
  double look_deg = 0;       ///< amplitude of the camera's yaw oscillation about its own centre
  double look_period_s = 6;
  bool sways = true;  ///< small pitch, roll and heave motions while driving
};

/// Pose of the body at a time. It is rotated first about its z by the heading, then about its y by
/// the pitch (positive: front down), then about its x by the roll.
struct Waypoint {
  double time_s = 0;
  Vector3d position_m = Vector3d::Zero();
  double heading_deg = 0, pitch_deg = 0, roll_deg = 0;
};

/// Random motion about the trajectory in all six degrees of freedom: smooth noise.
struct Shake {
  double from_s = 0, until_s = 1e9;
  double position_m = 0, angle_deg = 0;  ///< largest offset along and about each axis
  double period_s = 0.1;                 ///< time between two random values
};

/// A person or vehicle that moves straight from one point to another. It does not exist before and
/// afterwards.
struct Walk {
  Kind kind = Kind::kPerson;
  Vector2d from_m = Vector2d::Zero(), to_m = Vector2d::Zero();
  double start_s = 0, speed_mps = 1.3;
};

/// A vehicle that drives with the camera, at a varying distance.
struct Companion {
  Kind kind = Kind::kCar;
  double gap_m = 15;     ///< from the camera to its rear, along the camera's path
  double left_m = 0;     ///< lateral offset from that path
  double swing_m = 2;    ///< amplitude of the gap's oscillation
  double period_s = 11;  ///< of that oscillation
};

/// Moving objects. Periods are mean times between encounters; 0: none.
struct Traffic {
  std::vector<Companion> companions;
  double oncoming_s = 0;         ///< cars that come towards the camera
  double cyclists_s = 0;         ///< on the right, driving along
  double walkers_s = 0;          ///< on both pavements, in both directions
  double crossing_people_s = 0;  ///< people who cross the street ahead
  double crossing_cars_s = 0;    ///< cars that cross at the next junction
  double passers_s = 0;          ///< people who pass 0.8 to 6 m ahead of the camera
  std::vector<Walk> walks;       ///< must not collide with the body
};

/// Exposure, noise and faults of the two sensors.
struct Sensor {
  double exposure = 1.3;        ///< 1: radiance 1 gives grey level 255
  double exposure_swing = 0.1;  ///< relative amplitude of its change over time
  double exposure_period_s = 7;
  double right_gain = 1.03;
  double right_offset = -2;    ///< grey levels
  double noise = 1.3;          ///< dark noise, grey levels
  double shot_noise = 0.12;    ///< grey levels^2 per grey level
  double exposure_time_s = 0;  ///< motion blur
  double rain = 0;             ///< streaks per megapixel
  double row_offset_px = 0;    ///< largest vertical misalignment of the right camera
  int drop_every = 0;          ///< every n-th frame is lost; 0: none
  int duplicate_every = 0;     ///< every n-th frame repeats the previous one; 0: none
};

/// A scene: static world, camera, trajectory of the body that carries it, moving objects, light and
/// sensors.
struct Scene {
  std::string name;
  std::string summary;
  Site site = Site::kTown;
  Camera camera;
  Drive drive;
  std::vector<Waypoint> waypoints;  ///< in order of time; replace `drive` if there are any
  std::vector<Shake> shakes;        ///< added to a trajectory of waypoints
  Traffic traffic;
  Look look;
  Sensor sensor;
  double parked_cars = 0.5, trees = 0.5;
};

const std::vector<Scene>& scenes();

/// @throws std::invalid_argument for an unknown name; it lists the known ones.
const Scene& sceneByName(const std::string& name);

}  // namespace predictive_stereo::simulation
