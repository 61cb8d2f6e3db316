#include "evaluation/simulation/scene.h"

#include <stdexcept>

namespace predictive_stereo::simulation {
namespace {

using Scenes = std::vector<Scene>;

// Adds an empty street, straight on; the caller changes it before adding the next one.
Scene& add(Scenes& scenes, const char* name, const char* summary) {
  Scene& scene = scenes.emplace_back();
  scene.name = name;
  scene.summary = summary;
  return scene;
}
// The same with traffic.
Scene& addBusy(Scenes& scenes, const char* name, const char* summary) {
  Scene& scene = add(scenes, name, summary);
  scene.traffic.oncoming_s = 3.5;
  scene.traffic.cyclists_s = 7;
  scene.traffic.walkers_s = 1.5;
  scene.traffic.crossing_people_s = 4;
  scene.traffic.crossing_cars_s = 4;
  return scene;
}

// Light and noise of a room with ceiling lamps.
void setIndoorLight(Scene& scene, float lamp_pitch_m, float lamp_height_m, float lamp_strength) {
  scene.look.to_sun = Vector3f(0.08f, 0.05f, 1).normalized();
  scene.look.sun = 0.2f;  // the only light that casts shadows
  scene.look.ambient = 0.55f;
  scene.look.ceiling = {lamp_pitch_m, lamp_height_m, lamp_strength};
  scene.look.lamps = 1.5f;
  scene.sensor.exposure = 1.4;
  scene.sensor.exposure_swing = 0.05;
  scene.sensor.noise = 1.5;
}

void addDrone(Scenes& list) {
  Scene& s = add(list, "drone",
                 "in a hall: vibrates at rest, takes off, turns at 90 deg/s, hovers (300 frames)");
  s.site = Site::kHall;
  s.camera = {752, 480, 20, 436, 367.5, 0.51, 0.11, 0.2, 0.05, {0.6, 0.6, 0.4}};
  setIndoorLight(s, 4, 5.9f, 6);
  // At rest until 2 s; climbs until 4.5 s; turns until 9 s; flies to the chessboard until 11.5 s;
  // pitches down to it, hovers, climbs.
  s.waypoints = {{0, {0, 0, 0}, 0, 0, 0},
                 {2, {0, 0, 0}, 0, 0, 0},
                 {4.5, {0.1, -0.1, 1.4}, 0, 0, 0},
                 {5, {0.1, -0.1, 1.4}, 0, 0, 0},
                 {5.5, {0.1, -0.1, 1.4}, 22.5, 0, 0},
                 {6, {0.1, -0.1, 1.4}, 67.5, 0, 0},
                 {8, {0.1, -0.1, 1.4}, 247.5, 0, 0},
                 {8.5, {0.15, -0.05, 1.45}, 292.5, 0, 0},
                 {9, {0.3, 0.1, 1.5}, 315, 0, 0},
                 {10, {1.2, 0.6, 1.5}, 345, 8, -6},
                 {11.5, {3, 1, 1.5}, 360, 0, 0},
                 {12.3, {3, 1, 1.5}, 360, 52, 0},
                 {14.3, {3.1, 0.9, 1.5}, 363, 52, 0},
                 {15.5, {3, 1.1, 1.9}, 355, 48, 2}};
  s.shakes = {{0, 1e9, 0.0003, 0.06, 0.03},  // rotors
              {2.2, 1e9, 0.01, 0.5, 0.25},   // balance
              {2.2, 1e9, 0.03, 0.8, 0.9}};
}

void addRobot(Scenes& list) {
  Scene& s =
      add(list, "robot",
          "low above the floor of a corridor with white walls and people, 5 Hz (100 frames)");
  s.site = Site::kCorridor;
  s.camera = {640, 480, 5, 385, 321.5, 0.5, 0.12, 0.3, -0.1, {0.5, 0.45, 0.5}};
  setIndoorLight(s, 2.4f, 2.65f, 1.2f);
  s.sensor.exposure = 2.1;
  // Stands for 2 s, drives along one corridor, turns into the other one, stands again.
  s.waypoints = {
      {0, {4, -0.75, 0}, 0, 0, 0},     {2, {4, -0.75, 0}, 0, 0, 0},
      {3, {4.3, -0.75, 0}, 0, 0, 0},   {8, {7.3, -0.6, 0}, 4, 0, 0},
      {11, {9.1, -0.6, 0}, -3, 0, 0},  {16.5, {12.4, -0.75, 0}, 0, 0, 0},
      {19, {13.9, -0.2, 0}, 45, 0, 0}, {21, {14.3, 0.9, 0}, 90, 0, 0},
      {24, {14.3, 2.6, 0}, 90, 0, 0},  {25, {14.3, 2.8, 0}, 90, 0, 0},
  };
  s.shakes = {{2, 24.5, 0.001, 0.15, 0.25}};
  // Towards the camera, away from it, beside it, and across the junction ahead.
  s.traffic.walks = {
      {Kind::kPerson, {14.5, 0.5}, {-6, 0.5}, -5, 1.3},
      {Kind::kPerson, {5.5, -0.45}, {43, -0.45}, -0.2, 1.5},
      {Kind::kPerson, {22, 0.6}, {-6, 0.6}, 2, 1.2},
      {Kind::kPerson, {30, 0.65}, {-6, 0.65}, 4, 1.6},
      {Kind::kPerson, {14.3, -15}, {14.3, 20}, -1, 1.4},
      {Kind::kPerson, {14.3, -19}, {14.3, 20}, 1.5, 1.4},
      {Kind::kPerson, {15.45, 18}, {15.45, -20}, 2, 1.3},
      {Kind::kPerson, {15.45, 21}, {15.45, -21}, 11, 1.1},
  };
}

// A small camera at a hall's end, among people who pass near it.
void addPeople(Scenes& list) {
  for (const bool stands : {true, false}) {
    Scene& s =
        stands ? add(list, "people_standing", "a small camera stands; people pass at 0.8 to 6 m")
               : add(list, "people_slow", "a robot rolls at 0.2 m/s; people pass at 0.8 to 6 m");
    s.site = Site::kHall;
    s.camera = {640, 480, 10, 385, 321.5, 0.5, 0.12, 0.9, 0.05, {0.5, 0.45, 1.0}};
    setIndoorLight(s, 4, 5.9f, 6);
    s.traffic.passers_s = 1.5;
    s.waypoints = {{0, {-6.5, 0, 0}, 0, 0, 0}, {60, {-6.5, 0, 0}, 0, 0, 0}};
    if (stands) continue;
    s.waypoints.back() = {10, {-4.5, 0, 0}, 0, 0, 0};
    s.shakes = {{0, 1e9, 0.001, 0.1, 0.25}};
  }
}

void addHandheld(Scenes& list) {
  Scene& s = addBusy(list, "handheld",
                     "held by a person who walks along a pavement and looks around (200 frames)");
  s.camera = {640, 480, 15, 500, 318.5, 0.49, 0.1, 0, 0, {0.6, 0.6, 1.8}};
  s.waypoints = {{0, {-60, -8.7, 1.45}, 0, 0, 0},      {1, {-59.6, -8.7, 1.45}, 5, 3, 0},
                 {3, {-57.2, -8.8, 1.4}, 10, 5, -4},   {4.2, {-55.8, -8.8, 1.45}, 55, 0, 6},
                 {5.5, {-54.6, -8.7, 1.5}, 60, -8, 3}, {6.5, {-53.8, -8.7, 1.3}, 20, 6, -12},
                 {7.5, {-53.6, -8.7, 0.7}, 8, -4, -3}, {8.5, {-53.5, -8.7, 0.7}, 12, 2, 15},
                 {9.5, {-53.1, -8.8, 1.4}, -8, 6, 4},  {11.5, {-50.8, -8.8, 1.45}, -5, 8, -3},
                 {13.5, {-48.2, -8.7, 1.45}, 25, 0, 2}};
  s.shakes = {{-1, 1e9, 0.015, 1.2, 0.12}, {-1, 1e9, 0.04, 4, 0.45}};
}

void setStopsAndTurns(Drive& drive) {
  drive.stop_first_m = 48;
  drive.stop_every_m = 140;
  drive.turns = "LSR";
}

// What the camera's vehicle does.
void addDrives(Scenes& list) {
  Scene& street = addBusy(list, "street", "drives, brakes, stands, turns; all kinds of traffic");
  setStopsAndTurns(street.drive);
  addBusy(list, "straight", "drives straight on among traffic");
  Scene& turn = addBusy(list, "turn", "turns left and right at every junction");
  turn.drive.start_m = -30;
  turn.drive.turns = "LR";
  Scene& brake = addBusy(list, "brake", "drives fast and brakes hard, again and again");
  brake.drive = {-75, 13, 8, 25, 45, 1};
  Scene& standstill = addBusy(list, "standstill", "stands before a junction; only the others move");
  standstill.drive.start_m = -14;
  standstill.drive.cruise_mps = 0;
  add(list, "static", "drives straight on; nothing else moves");
  Scene& rotation = addBusy(list, "rotation", "stands and turns to both sides, up to 10 deg/s");
  rotation.drive.cruise_mps = 0;
  rotation.drive.start_m = -40;
  rotation.drive.sways = false;
  rotation.drive.look_deg = 12;
  rotation.drive.look_period_s = 7.5;
  Scene& fast = addBusy(list, "fast_rotation", "drives and swings to both sides at up to 20 deg/s");
  fast.drive.cruise_mps = 4;
  fast.drive.look_deg = 15;
  fast.drive.look_period_s = 4.7;
}

// Vehicles that drive with the camera.
void addCompanions(Scenes& list) {
  addBusy(list, "leader", "follows another car among oncoming traffic").traffic.companions = {
      {Kind::kCar, 13, 0, 3, 9}};
  Scene& crowded = addBusy(list, "crowded", "among tall vehicles that cover 40 % of the view");
  crowded.traffic.companions = {{Kind::kTruck, 15, 0, 2, 9},
                                {Kind::kBus, 6.5, 3.2, 1.5, 13},
                                {Kind::kTruck, 11, -3.0, 2, 11}};
  crowded.parked_cars = 0;
  Scene& near =
      addBusy(list, "near_half_moves", "close to two trucks and a bus: half of the view moves");
  near.traffic.companions = {{Kind::kTruck, 10, 0, 1.5, 9},
                             {Kind::kBus, 5.5, 3.2, 1, 13},
                             {Kind::kTruck, 11, -3.0, 2, 11}};
  near.parked_cars = 0;
  Scene& highway =
      add(list, "highway", "drives at 100 km/h among a car, a van and a truck of that speed");
  highway.traffic.companions = {
      {Kind::kCar, 18, 0, 4, 9}, {Kind::kVan, 9, 3.2, 3, 13}, {Kind::kTruck, 35, 0, 3, 11}};
  highway.drive.cruise_mps = 28;
  highway.parked_cars = 0;
}

// Light, and faults of the sensors.
void addConditions(Scenes& list) {
  Scene& rain = addBusy(list, "rain", "streaks of rain, different in every image, and dull light");
  rain.sensor.rain = 1500;
  rain.sensor.noise = 2.5;
  rain.look.sun = 0.2f;
  rain.look.ambient = 0.6f;
  rain.look.sky = 0.9f;
  Scene& night = addBusy(list, "night", "dark and noisy, with saturated lamps");
  night.look.sun = 0.0f;
  night.look.ambient = 0.10f;
  night.look.sky = 0.02f;
  night.look.headlights = 0.9f;
  night.look.lamps = 4;
  night.look.reflections = 0.3f;
  night.sensor.noise = 3;
  night.sensor.exposure = 1.6;
  Scene& saturated = addBusy(list, "saturated", "over-exposed, with quickly changing exposure");
  saturated.sensor.exposure = 2.2;
  saturated.sensor.exposure_swing = 0.35;
  saturated.sensor.exposure_period_s = 3;
  addBusy(list, "low_texture", "surfaces nearly without texture").look.contrast = 0.12f;
  Scene& blur = addBusy(list, "blur", "long exposure: motion blur while driving and turning");
  blur.sensor.exposure_time_s = 0.03;
  blur.drive.turns = "LR";
  blur.drive.start_m = -30;
  Scene& misaligned =
      addBusy(list, "misaligned", "right camera up to 1.5 rows off, as KITTI's are");
  misaligned.sensor.row_offset_px = 1.5;
  setStopsAndTurns(misaligned.drive);
  addBusy(list, "dropped", "every fifth frame is missing").sensor.drop_every = 5;
  addBusy(list, "duplicated", "every fifth frame repeats the previous one").sensor.duplicate_every =
      5;
}

}  // namespace

const std::vector<Scene>& scenes() {
  static const Scenes table = [] {
    Scenes list;
    for (const auto addTo :
         {addDrives, addCompanions, addConditions, addDrone, addRobot, addPeople, addHandheld})
      addTo(list);
    return list;
  }();
  return table;
}

const Scene& sceneByName(const std::string& name) {
  std::string names;
  for (const Scene& scene : scenes()) {
    if (scene.name == name) return scene;
    names += (names.empty() ? "" : ", ") + scene.name;
  }
  throw std::invalid_argument("scene = " + name + ": there is no such scene; choose one of " +
                              names);
}

}  // namespace predictive_stereo::simulation
