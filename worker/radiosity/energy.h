// The balance of energy of a solution: what is emitted, absorbed and lost.
#pragma once

#include <span>

#include "common/hierarchy/shard_data.h"
#include "worker/radiosity/solver.h"
#include "worker/radiosity/transport.h"

namespace isolux {

// Sets emitted_w (of lamps, and what lights bring), absorbed_w, escaped_w and energy_imbalance of
// the report. One reduction. `escape`: share of each own leaf's light that leaves the scene.
Status AddEnergy(const LeafSystem& leaves, std::span<const Lanes> irradiance,
                 std::span<const double> escape, Exchange& exchange, RoundReport& report);

// Sets medium_w, what the medium absorbs: what more would arrive without it, over the couplings
// that `without_medium` has, from what leaves radiate in this solution. `bounces`: whether they
// reflect all they receive, or only what lights bring. One product and two reductions; before
// AddEnergy, which counts it.
Status AddMediumPower(const LeafSystem& leaves, std::span<const Lanes> irradiance, bool bounces,
                      Transport& without_medium, Exchange& exchange, RoundReport& report);

}  // namespace isolux
