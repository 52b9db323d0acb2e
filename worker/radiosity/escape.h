// Light that leaves: rays, independent of all links, that reach no participating side. They tell
// which components of a scene are closed, and what share of its light a leaf loses.
#pragma once

#include <cstdint>
#include <vector>

#include "common/hierarchy/hierarchy.h"
#include "common/util/parallel.h"
#include "worker/radiosity/ray_scene.h"

namespace isolux {

// For each surface, whether its component of the scene is closed: none of n pooled
// cosine-distributed rays left it, with n ≥ 15/(a (1 − ρ̄)) for the accuracy a. Surfaces that see
// each other along a ray are one component. Depends on the scene and the seed alone.
std::vector<uint8_t> FindClosedSurfaces(const Hierarchy& hierarchy, const RayScene& rays,
                                        double accuracy, uint64_t seed, ThreadPool& pool);

// Share of cosine-distributed rays from an element that reach no participating side, from
// 8·kEscapePackets seeded rays.
inline constexpr int kEscapePackets = 2;
double EscapeShare(const Hierarchy& hierarchy, const RayScene& rays, const NodeId& id,
                   const ConvexPolygon& polygon, uint64_t seed);

}  // namespace isolux
