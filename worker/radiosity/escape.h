// Light that leaves: rays, independent of all links, that reach no participating side. They tell
// which components of a scene are closed, and what share of its light a leaf loses.
#pragma once

#include <cstdint>
#include <vector>

#include "common/hierarchy/hierarchy.h"
#include "common/hierarchy/mirrors.h"
#include "common/hierarchy/translucent_sheets.h"
#include "common/util/parallel.h"
#include "worker/radiosity/ray_scene.h"

namespace isolux {

// What a scout of the whole scene finds, for each surface. Depends on the scene and the seed alone.
struct Scout {
  std::vector<float> escape;    // share of cosine-distributed rays that reach no participating side
  std::vector<uint32_t> rays;   // that tell so
  std::vector<uint8_t> closed;  // whether none of n pooled rays left the surface's component of the
                                // scene, with n ≥ 15/(a (1 − ρ̄)) for the accuracy a
  // Where no ray left either, but they are too few to say so: what openings that none of them found
  // may change the light by, 1/(n (1 − ρ̄)), as share of it; else 0.
  std::vector<float> unseen_openings;
  std::vector<uint32_t> component;  // the lowest surface of the surface's component
};

// Whether what a ray meets is a side that takes part.
bool TakesPart(const Scene& scene, const RayHit& hit);

// Surfaces that see each other along a ray are one component. Shares of light that mirrors reflect
// are followed; what sheets pass on is not lost, but arrives in another component.
Scout ScoutEscapes(const Hierarchy& hierarchy, const RayScene& rays, const Mirrors& mirrors,
                   const TranslucentSheets& sheets, double accuracy, uint64_t seed,
                   ThreadPool& pool);

// Rays that tell what share of an element's light escapes: at least kEscapeRays, and more where
// much of the scene's power comes from, since what a lamp loses all else lacks: the share of it
// that the element emits, or reflects of what lights bring.
inline constexpr int kEscapeRays = 32, kPriorRays = 16;
int EscapeRaysOf(double share_of_power);

// Share of the light of an element that escapes: of so many seeded cosine-distributed rays, drawn
// towards the share of the element it is part of as by kPriorRays more.
double EscapeShare(const Hierarchy& hierarchy, const RayScene& rays, const Mirrors& mirrors,
                   const NodeId& id, const ConvexPolygon& polygon, double prior, int ray_count,
                   uint64_t seed);
// Standard deviation of a share that so many rays tell, those of the prior among them.
double EscapeDeviation(double share, double ray_count);

}  // namespace isolux
