#include "simulation/scene.h"

#include <stdexcept>

namespace predictive_stereo::simulation {
namespace {

Traffic lively() {
  Traffic t;
  t.oncoming_s = 3.5;
  t.cyclists_s = 7;
  t.walkers_s = 1.5;
  t.crossing_people_s = 4;
  t.crossing_cars_s = 4;
  return t;
}

std::vector<Scene> makeScenes() {
  std::vector<Scene> all;
  const auto scene = [&all](const char* name, const char* summary) -> Scene& {
    all.emplace_back();
    all.back().name = name;
    all.back().summary = summary;
    all.back().traffic = lively();
    return all.back();
  };
  {
    Scene& s = scene("street", "drives, brakes, stands, turns; all kinds of traffic");
    s.drive.stop_first_m = 48;
    s.drive.stop_every_m = 140;
    s.drive.turns = "LSR";
  }
  {
    Scene& s = scene("straight", "drives straight on among traffic");
    s.drive.turns = "S";
  }
  {
    Scene& s = scene("turn", "turns left and right at every junction");
    s.drive.start_m = -30;
    s.drive.turns = "LR";
  }
  {
    Scene& s = scene("brake", "drives fast and brakes hard, again and again");
    s.drive.cruise_mps = 13;
    s.drive.brake_mps2 = 8;
    s.drive.stop_first_m = 25;
    s.drive.stop_every_m = 45;
    s.drive.stop_s = 1;
    s.drive.turns = "S";
  }
  {
    Scene& s = scene("standstill", "stands before a junction; only the others move");
    s.drive.start_m = -14;
    s.drive.cruise_mps = 0;
  }
  {
    Scene& s = scene("static", "drives straight on; nothing else moves");
    s.traffic = Traffic();
    s.drive.turns = "S";
  }
  {
    Scene& s = scene("rotation", "stands and turns to both sides, up to 10 deg/s");
    s.drive.cruise_mps = 0;
    s.drive.start_m = -40;
    s.drive.sways = false;
    s.drive.look_deg = 12;
    s.drive.look_period_s = 7.5;
  }
  {
    Scene& s = scene("fast_rotation", "drives and swings to both sides at up to 20 deg/s");
    s.drive.cruise_mps = 4;
    s.drive.turns = "S";
    s.drive.look_deg = 15;
    s.drive.look_period_s = 4.7;
  }
  {
    Scene& s = scene("leader", "follows another car among oncoming traffic");
    s.traffic.companions = {{Kind::kCar, 13, 0, 3, 9}};
    s.drive.turns = "S";
  }
  {
    Scene& s = scene("crowded", "among tall vehicles that cover 40 % of the view");
    s.traffic.companions = {{Kind::kTruck, 15, 0, 2, 9},
                            {Kind::kBus, 6.5, 3.2, 1.5, 13},
                            {Kind::kTruck, 11, -3.0, 2, 11}};
    s.parked_cars = 0;
    s.drive.turns = "S";
  }
  {
    Scene& s =
        scene("near_half_moves", "close behind a truck, between others: half of the view moves");
    s.traffic.companions = {{Kind::kTruck, 10, 0, 1.5, 9},
                            {Kind::kBus, 5.5, 3.2, 1, 13},
                            {Kind::kTruck, 11, -3.0, 2, 11}};
    s.parked_cars = 0;
    s.drive.turns = "S";
  }
  {
    Scene& s = scene("highway", "drives at 100 km/h among others who do, and some oncoming ones");
    s.traffic = Traffic();
    s.traffic.companions = {
        {Kind::kCar, 18, 0, 4, 9}, {Kind::kVan, 9, 3.2, 3, 13}, {Kind::kTruck, 35, 0, 3, 11}};
    s.drive.cruise_mps = 28;
    s.drive.turns = "S";
    s.parked_cars = 0;
  }
  {
    Scene& s = scene("rain", "streaks of rain, different in every image, and dull light");
    s.sensor.rain = 1500;
    s.sensor.noise = 2.5;
    s.look.sun = 0.2f;
    s.look.ambient = 0.6f;
    s.look.sky = 0.9f;
    s.drive.turns = "S";
  }
  {
    Scene& s = scene("night", "dark and noisy, with saturated lamps");
    s.look.sun = 0.0f;
    s.look.ambient = 0.10f;
    s.look.sky = 0.02f;
    s.look.headlights = 0.9f;
    s.look.lamps = 4;
    s.look.reflections = 0.3f;
    s.sensor.noise = 3;
    s.sensor.exposure = 1.6;
    s.drive.turns = "S";
  }
  {
    Scene& s = scene("saturated", "over-exposed, with quickly changing exposure");
    s.sensor.exposure = 2.2;
    s.sensor.exposure_swing = 0.35;
    s.sensor.exposure_period_s = 3;
    s.drive.turns = "S";
  }
  {
    Scene& s = scene("low_texture", "surfaces nearly without texture");
    s.look.contrast = 0.12f;
    s.drive.turns = "S";
  }
  {
    Scene& s = scene("blur", "long exposure: motion blur while driving and turning");
    s.sensor.exposure_time_s = 0.03;
    s.drive.turns = "LR";
    s.drive.start_m = -30;
  }
  {
    Scene& s = scene("misaligned", "right camera up to 1.5 rows off, as KITTI's are");
    s.sensor.row_offset_px = 1.5;
    s.drive.stop_first_m = 48;
    s.drive.stop_every_m = 140;
    s.drive.turns = "LSR";
  }
  {
    Scene& s = scene("dropped", "every fifth frame is missing");
    s.sensor.drop_every = 5;
    s.drive.turns = "S";
  }
  {
    Scene& s = scene("duplicated", "every fifth frame shows the one before once more");
    s.sensor.duplicate_every = 5;
    s.drive.turns = "S";
  }
  return all;
}

}  // namespace

const std::vector<Scene>& scenes() {
  static const std::vector<Scene> table = makeScenes();
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
