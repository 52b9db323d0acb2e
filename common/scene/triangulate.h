// Cutting a polygon of any shape into triangles.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/vec.h"

namespace isolux {

struct Triangulation {
  std::vector<std::array<uint32_t, 3>> triangles;  // indices of corners, oriented as the polygon
  bool simple = true;  // false where the outline crosses itself, so that the areas do not add up
};

// Cuts off ears, seen along the polygon's mean normal, the best shaped first (of up to 64 corners;
// beyond, the first that is found). Corners on one line, outlines that touch themselves and holes
// tied in by a seam (the same point twice, with equal `ids`) are handled; triangles without area
// are left out. Takes time with up to the cube of the number of corners.
//   Source: ear clipping after [Meisters75].
Triangulation Triangulate(std::span<const Vec3> corners, std::span<const uint32_t> ids);

}  // namespace isolux
