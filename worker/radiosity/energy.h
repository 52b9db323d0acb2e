// The balance of energy of a solution: what is emitted, absorbed and lost.
#pragma once

#include <span>

#include "common/hierarchy/shard_data.h"
#include "worker/radiosity/solver.h"

namespace isolux {

// Sets emitted_w (of lamps, and what lights bring), absorbed_w, escaped_w and energy_imbalance of
// the report. One reduction. `escape`: share of each own leaf's light that leaves the scene.
Status AddEnergy(const LeafSystem& leaves, std::span<const Lanes> irradiance,
                 std::span<const double> escape, Exchange& exchange, RoundReport& report);

}  // namespace isolux
