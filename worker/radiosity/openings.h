// Openings too small for rays from everywhere to find: pinholes, gaps under doors, slits.
#pragma once

#include <cstdint>

#include "common/hierarchy/hierarchy.h"
#include "common/util/disjoint_sets.h"
#include "common/util/parallel.h"
#include "worker/radiosity/ray_scene.h"

namespace isolux {

// Joins the surfaces (numbers in `components`) that see each other past a free edge, one that no
// other polygon shares. From points just beyond it, nearer to it than it is long, two opposite rays
// each; what they meet is joined where nothing stands between. Where all is one component already,
// nothing is traced; else at most 131,072 pairs of rays.
void JoinPastFreeEdges(const Hierarchy& hierarchy, const RayScene& rays, uint64_t seed,
                       ThreadPool& pool, DisjointSets* components);

}  // namespace isolux
