// Sides of polygons that lie wholly against another polygon: the floor under a block, the back of
// a picture on a wall. Two polygons in one plane neither see nor hide each other, so light would
// pass through the cover; what is covered must not take part.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/scene/scene.h"

namespace isolux {

// A surface of polygons joined edge to edge in one plane, and where the rest of what it belongs to
// stands. Made before polygons are cut.
struct Sheet {
  double area_m2 = 0;
  Vec3 normal{0.0};
  int body = 0;  // 1: polygons that share its edges stand off to the side of the normal; -1: to the
                 // other; 0: to both or to none
};

struct Sheets {
  std::vector<Sheet> sheets;
  std::vector<uint32_t> sheet_of;  // of each polygon
};

Sheets FindSheets(const Scene& scene, std::span<const uint32_t> plane_of);

struct Uncovered {
  uint64_t sides = 0;          // that no longer take part
  uint32_t first_polygon = 0;  // of them
};

// Takes the flags of covered sides from polygons and marks them as covered. `source[p]` is the
// polygon, before cutting, that polygon p is a piece of.
//
// A measured gap says which of two polygons is on which side. Where there is none, the smaller of
// two sheets is on the side where its body stands (a block on a floor); without a body it lies on
// the front of the larger (a carpet), or, if they face opposite ways, back to back with it, as
// sheets of equal size do (a wall with two materials).
Uncovered DropCoveredSides(const Sheets& sheets, std::span<const uint32_t> source, Scene* scene);

}  // namespace isolux
