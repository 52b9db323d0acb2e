// Fewer, better shaped polygons: what was cut into triangles becomes quads again, where that
// changes neither the surface nor what it is made of.
#pragma once

#include <cstdint>
#include <vector>

#include "common/scene/scene.h"

namespace isolux {

// Joins pairs of triangles that share an edge, a material and their sides into one convex planar
// quad, where the quad is no more of a sliver than the worse of the two. Best shaped pairs first;
// the result depends on the scene alone. The quad takes the place of the earlier triangle and keeps
// the lower file number. `plane_of` (may be null) holds a number for each polygon and follows them.
// Returns how many pairs were joined.
uint64_t MergeTrianglePairs(Scene* scene, std::vector<uint32_t>* plane_of = nullptr);

// Takes out the entries that are marked.
template <typename T>
void EraseMarked(const std::vector<bool>& marked, std::vector<T>* entries) {
  size_t kept = 0;
  for (size_t i = 0; i < marked.size(); ++i) {
    if (!marked[i]) (*entries)[kept++] = (*entries)[i];
  }
  entries->resize(kept);
}

struct RegionMerge {
  uint64_t gone = 0;           // polygons fewer than before, triangles not yet paired
  uint32_t first_polygon = 0;  // file number of a polygon that was merged, where any was
};

// Divides regions of polygons that share edges, a plane, a material, their orientation and their
// sides anew into triangles, where that leaves much less of them and makes no slivers: a wall in
// 100,000 triangles becomes two. `plane_of` from FindPlanes follows the polygons. New triangles
// take the lowest file number of their region and stand where its first polygon stood. Takes about
// n log n.
RegionMerge MergeRegions(Scene* scene, std::vector<uint32_t>* plane_of);

}  // namespace isolux
