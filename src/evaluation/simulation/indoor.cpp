#include "evaluation/simulation/worlds.h"

namespace predictive_stereo::simulation {
namespace {

Builder startWorld(uint32_t seed, double albedo, double contrast, Primitives& out) {
  Builder b({}, seed, 0, out, 0);
  b.add(Shape::kGround, kLinoleum, Vector3d::Zero(), Vector3d::Ones(), albedo).contrast =
      static_cast<float>(contrast);
  return b;
}

// Coordinates at the front of a wall: along it, out of it, height.
struct Front {
  Vector3d origin, along, out;

  Vector3d at(double a, double o, double z) const {
    return origin + a * along + o * out + Vector3d(0, 0, z);
  }
  // A box given by two corners.
  Primitive& box(Builder& b, Material material, const Vector3d& low, const Vector3d& high,
                 double albedo) const {
    const Vector3d p = at(low.x(), low.y(), low.z()), q = at(high.x(), high.y(), high.z());
    return b.box(material, 0.5 * (p + q), 0.5 * (q - p).cwiseAbs(), albedo);
  }
};

// Coordinates of the world.
const Front kWorld{Vector3d::Zero(), Vector3d::UnitX(), Vector3d::UnitY()};

// A door with its frame, handle and number.
void addDoor(const Front& front, double at, Random& random, Builder& b) {
  const double leaf = random.uniform(0.2, 0.5), frame = 0.3;
  front.box(b, kBark, {at - 0.45, 0, 0}, {at + 0.45, 0.015, 2.05}, leaf).contrast = 0.3f;
  for (const double side : {-0.5, 0.45})
    front.box(b, kMetal, {at + side, 0, 0}, {at + side + 0.05, 0.04, 2.1}, frame);
  front.box(b, kMetal, {at - 0.5, 0, 2.05}, {at + 0.5, 0.04, 2.1}, frame);
  front.box(b, kMetal, {at + 0.28, 0.015, 1.02}, {at + 0.4, 0.06, 1.05}, 0.6);
  front.box(b, kSign, {at - 0.75, 0, 1.45}, {at - 0.58, 0.01, 1.57}, 0.8);
}

// One side of a corridor, `length_m` long: nearly white, with a door every few metres and sometimes
// an object between them.
void addCorridorWall(const Front& front, double length_m, Random& random, Builder& b) {
  constexpr double kHeight_m = 2.7, kThick_m = 0.2;
  front.box(b, kPlaster, {0, -kThick_m, 0}, {length_m, 0, kHeight_m}, 0.72).contrast = 0.2f;
  front.box(b, kPlaster, {0, 0, 0}, {length_m, 0.015, 0.08}, 0.3);
  for (double at = random.uniform(1.0, 2.5); at < length_m - 1; at += random.uniform(3.2, 4.6)) {
    addDoor(front, at, random, b);
    const double next = at + random.uniform(1.3, 1.9);
    if (next > length_m - 1) break;
    const double what = random.uniform();
    if (what < 0.35) {  // a poster
      const double low = random.uniform(1.0, 1.3), half = random.uniform(0.25, 0.45);
      front.box(b, kPrint, {next - half, 0, low}, {next + half, 0.01, low + 0.84}, 0.75);
    } else if (what < 0.5) {  // a fire extinguisher
      b.rod(kPaint, front.at(next, 0.12, 0.25), front.at(next, 0.12, 0.75), 0.08, 0.15);
      front.box(b, kSign, {next - 0.1, 0, 1.7}, {next + 0.1, 0.01, 1.9}, 0.5);
    } else if (what < 0.65) {  // a radiator
      for (double x = -0.5; x < 0.5; x += 0.1)
        front.box(b, kMetal, {next + x, 0.03, 0.15}, {next + x + 0.07, 0.1, 0.75}, 0.65);
    } else if (what < 0.75) {  // a chair
      front.box(b, kCloth, {next - 0.25, 0.05, 0.42}, {next + 0.25, 0.5, 0.48}, 0.25);
      front.box(b, kCloth, {next - 0.25, 0.03, 0.6}, {next + 0.25, 0.08, 0.95}, 0.25);
      for (const double x : {-0.22, 0.22})
        for (const double y : {0.08, 0.47})
          b.rod(kMetal, front.at(next + x, y, 0), front.at(next + x, y, 0.42), 0.015, 0.2);
    }
  }
}

// Goods on a shelf of three boards, `length_m` long.
void addShelf(const Front& front, double at, double length_m, Random& random, Builder& b) {
  constexpr double kDepth_m = 0.9, kStorey_m = 1.3;
  for (double x = 0; x <= length_m + 0.01; x += 0.5 * length_m)
    for (const double y : {0.1, kDepth_m})
      front.box(b, kMetal, {at + x - 0.04, y - 0.04, 0}, {at + x + 0.04, y + 0.04, 4.2}, 0.2);
  for (int storey = 0; storey < 3; ++storey) {
    const double z = 0.1 + storey * kStorey_m;
    front.box(b, kMetal, {at, 0.06, z - 0.06}, {at + length_m, kDepth_m + 0.05, z}, 0.3);
    for (double x = at + 0.1; x < at + length_m - 0.5;) {
      const double width = random.uniform(0.35, 0.9), height = random.uniform(0.3, 1.0);
      const double depth = random.uniform(0.5, kDepth_m);
      const Material material = random.chance(0.4) ? kPrint : random.chance(0.5) ? kCloth : kMetal;
      if (random.chance(0.8))
        front.box(b, material, {x, 0.1, z}, {x + width, depth, z + height},
                  random.uniform(0.15, 0.7));
      x += width + random.uniform(0.03, 0.3);
    }
  }
}

// A machine: a body, a cabinet, a chimney.
void addMachine(const Front& front, double at, Random& random, Builder& b) {
  const double length = random.uniform(1.6, 2.6), height = random.uniform(1.2, 2.2);
  front.box(b, kMetal, {at, 0.4, 0.1}, {at + length, 1.8, height}, random.uniform(0.25, 0.5));
  front.box(b, kMetal, {at + 0.2, 1.8, 0.5}, {at + 0.8, 1.95, 1.4}, 0.6);
  front.box(b, kSign, {at + 1.0, 1.8, 0.9}, {at + 1.3, 1.82, 1.1}, 0.8);
  b.rod(kMetal, front.at(at + 0.5, 1.0, height), front.at(at + 0.5, 1.0, 6.9), 0.15, 0.4);
}

}  // namespace

void addHall(uint32_t seed, Primitives& out) {
  constexpr double kHeight_m = 7;
  Builder b = startWorld(seed, 0.42, 0.02, out);
  Random random(hashOf(seed, 1));
  kWorld.box(b, kMetal, {-8, -8, kHeight_m}, {16, 8, kHeight_m + 0.1}, 0.4);
  for (double x = -6; x < 16; x += 4)  // girders and lamps
    kWorld.box(b, kMetal, {x - 0.1, -8, kHeight_m - 0.5}, {x + 0.1, 8, kHeight_m}, 0.25);
  for (double x = -4; x < 16; x += 4)
    for (const double y : {-4.0, 0.0, 4.0})
      kWorld.box(b, kLamp, {x - 0.6, y - 0.1, 5.9}, {x + 0.6, y + 0.1, 5.98}, 0.8);
  const Front walls[] = {{{16, -8, 0}, Vector3d::UnitY(), -Vector3d::UnitX()},
                         {{16, 8, 0}, -Vector3d::UnitX(), -Vector3d::UnitY()},
                         {{-8, 8, 0}, -Vector3d::UnitY(), Vector3d::UnitX()},
                         {{-8, -8, 0}, Vector3d::UnitX(), Vector3d::UnitY()}};
  for (int i = 0; i < 4; ++i) {
    const Front& wall = walls[i];
    const double length = i % 2 ? 24 : 16;
    // One wall of bricks, the others nearly white.
    const bool bricks = i == 1;
    wall.box(b, bricks ? kBrick : kPlaster, {0, -0.2, 0}, {length, 0, kHeight_m},
             bricks ? 0.35 : 0.65)
        .contrast = bricks ? 1.0f : 0.25f;
    for (double x = 2; x < length; x += 4) {
      wall.box(b, kMetal, {x - 0.12, 0, 0}, {x + 0.12, 0.25, kHeight_m}, 0.3);
      wall.box(b, kLamp, {x + 0.8, 0, 4.6}, {x + 3.0, 0.01, 6.2}, 0.6);  // a window
      wall.box(b, kMetal, {x + 1.85, 0, 4.6}, {x + 1.95, 0.04, 6.2}, 0.2);
    }
    for (double x = 1.0; x < length - 4; x += 4) {
      const double what = random.uniform();
      if (what < 0.4)
        addShelf(wall, x, 3.2, random, b);
      else if (what < 0.6)
        addMachine(wall, x, random, b);
      else if (what < 0.8)
        wall.box(b, kPrint, {x + 1.3, 0, 1.2}, {x + 2.7, 0.02, 2.2}, 0.7);
    }
    b.rod(kMetal, wall.at(0.1, 0.3, 4.3), wall.at(length - 0.1, 0.3, 4.3), 0.08, 0.5);
  }
  // A few crates, barrels and tables on the floor, none near the chessboard.
  for (const Vector3d& at : {Vector3d(9, -3, 0), Vector3d(10.5, 3.5, 0), Vector3d(-4, 4, 0),
                             Vector3d(-3.5, -4, 0), Vector3d(2, -5, 0), Vector3d(6, 5.2, 0)}) {
    const double half = random.uniform(0.3, 0.5), height = random.uniform(0.5, 1.1);
    kWorld.box(b, kBark, at - Vector3d(half, half, 0), at + Vector3d(half, half, height), 0.35);
    kWorld.box(b, kPrint, at + Vector3d(-0.2, -0.25, height),
               at + Vector3d(0.25, 0.2, height + 0.35), 0.6);
    const Vector3d barrel = at + Vector3d(0.3, half + 0.5, 0);
    b.rod(kPaint, barrel, barrel + Vector3d(0, 0, 0.9), 0.29, random.uniform(0.1, 0.4));
  }
  b.box(kChessboard, {4.1, 1, 0.005}, {0.5, 0.65, 0.005}, 0.85);
}

void addCorridor(uint32_t seed, Primitives& out) {
  constexpr double kHeight_m = 2.7;
  Builder b = startWorld(seed, 0.36, 0.5, out);
  Random random(hashOf(seed, 1));
  kWorld.box(b, kPanels, {-6.2, -22.2, kHeight_m}, {44.2, 22.2, kHeight_m + 0.1}, 0.7);
  const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY();
  // The walls of one corridor end at the backs of the other one's walls: no coplanar faces.
  addCorridorWall({{-6, -1.25, 0}, x, y}, 19.3, random, b);
  addCorridorWall({{-6, 1.25, 0}, x, -y}, 19.3, random, b);
  addCorridorWall({{16.2, -1.25, 0}, x, y}, 27.8, random, b);
  addCorridorWall({{16.2, 1.25, 0}, x, -y}, 27.8, random, b);
  addCorridorWall({{13.5, 1.25, 0}, y, x}, 20.75, random, b);
  addCorridorWall({{16, 1.25, 0}, y, -x}, 20.75, random, b);
  addCorridorWall({{13.5, -22, 0}, y, x}, 20.75, random, b);
  addCorridorWall({{16, -22, 0}, y, -x}, 20.75, random, b);
  // A door at each end.
  const Front ends[] = {{{-6, -1.5, 0}, y, x},
                        {{44, -1.5, 0}, y, -x},
                        {{13.25, -22, 0}, x, y},
                        {{13.25, 22, 0}, x, -y}};
  for (const Front& end : ends) {
    end.box(b, kPlaster, {0, -0.2, 0}, {3, 0, kHeight_m}, 0.7).contrast = 0.2f;
    addDoor(end, 1.5, random, b);
  }
  for (double at = -4.8; at < 43; at += 2.4)
    if (at < 12.5 || at > 17)
      kWorld.box(b, kLamp, {at - 0.6, -0.15, kHeight_m - 0.03}, {at + 0.6, 0.15, kHeight_m}, 0.9);
  for (double at = -21.6; at < 22; at += 2.4)
    kWorld.box(b, kLamp, {14.6, at - 0.6, kHeight_m - 0.03}, {14.9, at + 0.6, kHeight_m}, 0.9);
  for (const double at : {13.0, 16.5})  // signs that hang from the ceiling
    kWorld.box(b, kSign, {at - 0.02, -0.25, 2.25}, {at + 0.02, 0.25, 2.45}, 0.6);
}

}  // namespace predictive_stereo::simulation
