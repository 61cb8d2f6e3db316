/// What happens in a scene: the one table of scenes by name.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "simulation/material.h"
#include "simulation/models.h"

namespace predictive_stereo::simulation {

/// The static world around the camera.
enum class Site : uint8_t {
  kTown,      ///< an endless one, see town.h
  kHall,      ///< see indoor.h
  kCorridor,  ///< see indoor.h
};

/// The stereo camera, and the body that carries it.
struct Camera {
  int width = 1242, height = 375;  ///< [px]
  double rate_hz = 10;
  double focal_px = 721.5377;               ///< at this width, as cx_px
  double cx_px = 609.56, cy_share = 0.461;  ///< principal point; the latter of the height
  double baseline_m = 0.54;
  double up_m = 1.65;                        ///< the camera above the body's origin
  double down_rad = 0.012;                   ///< how far it looks down
  Eigen::Vector3d body_m = {4.2, 1.8, 1.5};  ///< length, width, height
};

/// How the body drives along the town's streets.
struct Drive {
  double start_m = -75;   ///< x at which it begins, on the street y = 0; junctions at 0, 100 ..
  double cruise_mps = 8;  ///< 0: it stands
  double brake_mps2 = 2.5;
  double stop_first_m = -1;  ///< way to the first stop; negative: none
  double stop_every_m = 0;   ///< further stops; 0: none
  double stop_s = 2;         ///< how long it stands
  std::string turns;         ///< at the junctions: S straight on, L left, R right; repeated
  double look_deg = 0;       ///< swings to both sides by this angle, about the camera itself
  double look_period_s = 6;
  bool sways = true;  ///< small pitch, roll and heave while driving
};

/// Where the body is at a time, and how it is turned: first about its z by the heading, then about
/// its y by the pitch (positive: its front goes down), then about its x by the roll.
struct Waypoint {
  double time_s = 0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  double heading_deg = 0, pitch_deg = 0, roll_deg = 0;
};

/// Irregular motion about the waypoints, in all six degrees of freedom: smooth noise.
struct Shake {
  double from_s = 0, until_s = 1e9;
  double position_m = 0, angle_deg = 0;  ///< largest offset along and about each axis
  double period_s = 0.1;                 ///< from one random value to the next
};

/// A person or vehicle that goes straight from one point to another, and is not there before and
/// after.
struct Walk {
  Kind kind = Kind::kPerson;
  Eigen::Vector2d from_m = Eigen::Vector2d::Zero(), to_m = Eigen::Vector2d::Zero();
  double start_s = 0, speed_mps = 1.3;
};

/// A vehicle that goes along with the camera, now faster and now slower.
struct Companion {
  Kind kind = Kind::kCar;
  double gap_m = 15;     ///< from the camera to its rear, along the camera's way
  double left_m = 0;     ///< beside that way
  double swing_m = 2;    ///< how much the gap changes to both sides
  double period_s = 11;  ///< of that change
};

/// Who else moves. Periods are mean times between encounters; 0: none.
struct Traffic {
  std::vector<Companion> companions;
  double oncoming_s = 0;         ///< cars that come towards the camera
  double cyclists_s = 0;         ///< on the right, driving along
  double walkers_s = 0;          ///< on both pavements, in both directions
  double crossing_people_s = 0;  ///< who cross the street ahead
  double crossing_cars_s = 0;    ///< who cross at the next junction
  std::vector<Walk> walks;       ///< none of them may meet the body
};

/// What the sensors make of it.
struct Sensor {
  double exposure = 1.3;        ///< radiance 1 gives 255
  double exposure_swing = 0.1;  ///< its relative change over time
  double exposure_period_s = 7;
  double right_gain = 1.03;
  double right_offset = -2;    ///< grey levels
  double noise = 1.3;          ///< grey levels, in the dark
  double shot_noise = 0.12;    ///< grey levels^2 per grey level
  double exposure_time_s = 0;  ///< motion blur
  double rain = 0;             ///< streaks per megapixel
  double row_offset_px = 0;    ///< largest vertical misalignment of the right camera
  int drop_every = 0;          ///< every so many instants without a frame
  int duplicate_every = 0;     ///< every so many frames repeats the one before
};

/// A scene is a site, a camera, the path of the body that carries it, and who else moves; and what
/// the light and the sensors make of it.
struct Scene {
  std::string name;
  std::string summary;
  Site site = Site::kTown;
  Camera camera;
  Drive drive;
  std::vector<Waypoint> waypoints;  ///< in order of time; the path in place of `drive`, if any
  std::vector<Shake> shakes;        ///< of a path of waypoints
  Traffic traffic;
  Look look;
  Sensor sensor;
  double parked_cars = 0.5, trees = 0.5;
};

const std::vector<Scene>& scenes();

/// @throws std::invalid_argument that lists the names there are.
const Scene& sceneByName(const std::string& name);

}  // namespace predictive_stereo::simulation
