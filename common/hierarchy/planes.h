// Which polygons lie in one plane, and how near counts as touching. For the importer, which cuts
// and merges by it, and the hierarchy, by which no light passes within a plane.
#pragma once

#include <cstdint>
#include <vector>

#include "common/scene/scene.h"

namespace isolux {

// What lies no farther apart touches: the rounding of coordinates printed with six digits, which is
// up to 1.4e-6 of the extent of a scene at the origin, with room to spare; but never more than a
// thousandth of the smaller thing, so that no detail is swallowed in a scene that is large only
// because of its surroundings.
inline constexpr double kContactOfExtent = 5e-6;
inline constexpr double kContactOfSize = 1e-3;
inline double ContactTolerance(double extent_m, double size_m) {
  const double of_extent = kContactOfExtent * extent_m, of_size = kContactOfSize * size_m;
  return of_extent < of_size ? of_extent : of_size;
}

Bounds3 BoundsOf(const Scene& scene, uint32_t polygon);
// Diagonal of the box of all polygons, metres.
double ExtentOf(const Scene& scene);

// Numbers of the planes that polygons lie in, from 0 in the order of the polygons; the orientation
// does not matter. Grown from the largest polygons over near neighbours whose corners all lie in
// the plane of what has been found so far, within the contact tolerance: measured against one plane
// and not from neighbour to neighbour, so that a finely tessellated sphere falls into no more than
// facets. Planes that agree within 1e-6 in direction and in offset over the extent have one number
// even where they are far apart.
std::vector<uint32_t> FindPlanes(const Scene& scene);

}  // namespace isolux
