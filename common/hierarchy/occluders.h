// Large convex occluders: what a wall is for visibility, however it was divided. For proofs that
// something is hidden, which take one convex polygon.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/scene/scene.h"

namespace isolux {

struct OccluderPolygon {
  static constexpr size_t kMostCorners = 16;

  std::vector<Vec3> corners;  // convex, 3 to kMostCorners, counter-clockwise about the normal
  Vec3 normal{0.0};           // of length 1; either side blocks
  uint32_t plane = 0;         // as Hierarchy::plane_of has it
  // Lowest number of the polygons that were joined. What the occluder covers belongs to polygons of
  // its plane.
  uint32_t first_polygon = 0;
};

// All polygons of the scene as few convex ones: neighbours in one plane that share edges are
// joined whatever they are made of and whichever sides take part. Every occluder is covered by
// polygons of the scene, to within the rounding of coordinates (planes.h), and none is left out.
// `plane_of` from FindPlanes. Takes about n log n.
std::vector<OccluderPolygon> MergeOccluders(const Scene& scene, std::span<const uint32_t> plane_of);

}  // namespace isolux
