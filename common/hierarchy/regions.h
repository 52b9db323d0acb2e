// Regions: polygons joined edge to edge, and their outlines divided anew into few triangles or
// convex polygons. For merging what a modeller's tessellation has taken apart.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/scene/scene.h"

namespace isolux {

// A polygon by its corners (numbers of vertices), counter-clockwise.
using Loop = std::vector<uint32_t>;

// The corners of all polygons, those of one plane oriented alike: as the first of the plane.
struct AlikeLoops {
  std::vector<Loop> loops;
  std::vector<Vec3> normals;  // of length 1
  std::vector<double> areas;  // m²
};
AlikeLoops OrientAlike(const Scene& scene, std::span<const uint32_t> plane_of);

struct Region {
  std::vector<uint32_t> polygons;  // ascending
  std::vector<Loop> outline;  // the outer loop and those of holes, in no order; all directed so
                              // that the region is to the left
};

// Divides polygons into regions: those with the same key that share an edge, run along in opposite
// directions, that no third of them has. `loops[p]` are the corners of polygon p, with its
// orientation reversed where the caller wants it so.
std::vector<Region> FindRegions(const Scene& scene, std::span<const Loop> loops,
                                std::span<const uint64_t> key, std::span<const Vec3> normals);

// The region's outline without corners that lie on a line with their neighbours (within
// `tolerance_m`), in triangles; nothing where it has more than a few hundred corners, or where the
// areas do not agree with those of its polygons because they overlap.
std::optional<std::vector<std::array<uint32_t, 3>>> Retriangulate(const Scene& scene,
                                                                  const Region& region,
                                                                  const Vec3& normal,
                                                                  double area_m2,
                                                                  double tolerance_m);

// Joins cells across shared edges as long as the union is convex and has no more than
// `most_corners`. Cells are convex, counter-clockwise about `normal`, and lie in one plane.
std::vector<Loop> JoinConvex(const Scene& scene, std::vector<Loop> cells, const Vec3& normal,
                             size_t most_corners);

}  // namespace isolux
