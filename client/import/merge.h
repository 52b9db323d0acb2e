// Fewer, better shaped polygons: what was cut into triangles becomes quads again, where that
// changes neither the surface nor what it is made of.
#pragma once

#include <cstdint>

#include "common/scene/scene.h"

namespace isolux {

// Joins pairs of triangles that share an edge, a material and their sides into one convex planar
// quad, where the quad is no more of a sliver than the worse of the two. Best shaped pairs first;
// the result depends on the scene alone. The quad takes the place of the earlier triangle and keeps
// the lower file number. Returns how many pairs were joined.
uint64_t MergeTrianglePairs(Scene* scene);

}  // namespace isolux
