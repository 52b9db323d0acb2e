// Tiny scenes with known answers, built in code.
#pragma once

#include <array>

#include "common/scene/scene.h"

namespace isolux::testing {

// A closed box [0,size] seen from inside: six quads (x low, x high, y low, y high, z low, z high),
// fronts inwards, fronts only.
struct BoxFaces {
  std::array<Rgb, 6> reflectance{};
  std::array<Rgb, 6> exitance{};
};
Scene BoxRoom(const Vec3& size_m, const BoxFaces& faces);

// Closed unit cube with the same reflectance and exitance on all faces: B = E / (1 − ρ).
Scene FurnaceCube(double reflectance, double exitance);

// The Cornell box as published (metres; open in front), both blocks, light in the ceiling; fronts
// emit; both sides take part where `both_sides`.
Scene CornellBox(bool both_sides);

// A closed grey room, 4 × 3 × 3 m, whose lamp is a strip of 2 m and this height that shines on the
// wall close behind it.
Scene RoomWithStrip(double before_wall_m, double height_m);

// A closed room with `blocks` random boxes standing or floating in it and one or two random lamps,
// from a seed; reflectances up to 0.8.
Scene RandomRoom(uint64_t seed, int blocks);

}  // namespace isolux::testing
