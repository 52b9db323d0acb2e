// Rows that closure has to bend far. Light leaks there, or a surface is there twice, or links are
// missing: closure makes rows add up, but cannot know where the light should go.
#pragma once

#include "common/hierarchy/shard_data.h"
#include "worker/radiosity/solver.h"

namespace isolux {

// A row off by more than this share of itself. Rows scatter, so some always are: 1 to 2 % of the
// area of a closed room with little in it, 5 to 10 % of a furnished one at a few percent of error,
// more where links are coarse; half of a cube that lacks a wall and is taken for closed.
inline constexpr double kLeak = 0.25;

// Of the leaves of all workers that receive light, the same at each of them. One reduction. `bend`:
// of own leaves, as ClosureSummary has it; empty where no rows were closed. `scene_area_m2`: of all
// sides that take part.
Result<Leaks> CountLeaks(const LeafSystem& leaves, std::span<const Lanes> irradiance,
                         std::span<const double> bend, double scene_area_m2, Exchange& exchange);

}  // namespace isolux
