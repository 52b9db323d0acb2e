// Which surfaces share vertices in the output: those over which irradiance is continuous.
#pragma once

#include <cstdint>
#include <vector>

#include "common/hierarchy/hierarchy.h"

namespace isolux {

// Number of the group of each surface, from 0. The surfaces of a group lie in one plane, face the
// same way, reflect and emit alike, and hang together by borders on which nothing stands: the floor
// under a block and the two sides of a partition are not averaged with what is before them.
std::vector<uint32_t> FindWeldGroups(const Hierarchy& hierarchy);

}  // namespace isolux
