// Lights that cannot come in: a room that no ray has left is lit by no light outside of it, however
// bright that is, and need not be searched for where it might get through.
#pragma once

#include <cstdint>
#include <vector>

#include "common/hierarchy/hierarchy.h"
#include "worker/radiosity/escape.h"

namespace isolux {

// Of each light of the scene the closed components (Scout::component) that it shines in, in
// ascending order: of the sun and of what else is infinitely far away none, of others those of the
// surfaces that rays from it meet. A light inside of a closed component meets nothing else.
std::vector<std::vector<uint32_t>> ClosedComponentsLit(const Hierarchy& hierarchy,
                                                       const RayScene& rays, const Scout& scout,
                                                       uint64_t seed);

}  // namespace isolux
