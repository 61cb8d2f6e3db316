/// Models of vehicles, people, plants and buildings, each built from a few primitives.
#pragma once

#include "evaluation/simulation/builder.h"

namespace predictive_stereo::simulation {

enum class Kind : uint8_t { kCar, kVan, kTruck, kBus, kPerson, kCyclist };
constexpr const char* kKindNames[] = {"car", "van", "truck", "bus", "person", "cyclist"};

/// Length, width and height [m] of the model of this kind and seed.
Eigen::Vector3d sizeOf(Kind kind, uint32_t seed);

/// Adds a model. `stride_m` is the distance it has moved: legs and arms swing with it.
void addThing(Kind kind, uint32_t seed, const Place& place, double stride_m, int object,
              Primitives& out);

void addTree(const Place& place, uint32_t seed, Primitives& out);
void addBush(const Place& place, double length_m, double height_m, uint32_t seed, Primitives& out);
void addLampPost(const Place& place, Primitives& out);
void addSignPost(const Place& place, uint32_t seed, Primitives& out);
void addFence(const Place& place, double length_m, uint32_t seed, Primitives& out);
/// A house whose front, `width_m` long, faces along the place's heading.
void addHouse(const Place& place, double width_m, double depth_m, uint32_t seed, Primitives& out);

}  // namespace predictive_stereo::simulation
