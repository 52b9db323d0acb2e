// A scene of grey surfaces and lamps of one colour, solved in one channel: what goes in and what
// comes out (EffectsPlan::channels).
#pragma once

#include <span>
#include <vector>

#include "common/scene/effects_plan.h"
#include "worker/radiosity/solver.h"

namespace isolux {

// Exitance in the plan's unit, reflectances grey.
LeafSystemOf<Single> ToOneChannel(const LeafSystem& leaves, const EffectsPlan& plan);
// Irradiances as the number that times the light's colour is nearest to them: of what InColour
// gave, that number to the bit.
std::vector<Single> ToOneChannel(std::span<const Lanes> irradiance, const EffectsPlan& plan);

SolverResult InColour(const SolverResultOf<Single>& grey, const EffectsPlan& plan);

}  // namespace isolux
