/// What happens in a scene: the one table of scenes by name.
#pragma once

#include <string>
#include <vector>

#include "simulation/material.h"
#include "simulation/models.h"

namespace predictive_stereo::simulation {

/// How the camera drives.
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

struct Scene {
  std::string name;
  std::string summary;
  Drive drive;
  Traffic traffic;
  Look look;
  Sensor sensor;
  double parked_cars = 0.5, trees = 0.5;
};

const std::vector<Scene>& scenes();

/// @throws std::invalid_argument that lists the names there are.
const Scene& sceneByName(const std::string& name);

}  // namespace predictive_stereo::simulation
