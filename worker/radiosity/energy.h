// The balance of energy of a solution: what is emitted, absorbed and lost.
#pragma once

#include <array>
#include <span>

#include "common/hierarchy/shard_data.h"
#include "worker/radiosity/solver.h"
#include "worker/radiosity/transport.h"

namespace isolux {

// Sets emitted_w (of lamps, and what lights bring), absorbed_w, escaped_w and energy_imbalance of
// the report. One reduction. `escape`: share of each own leaf's light that leaves the scene.
Status AddEnergy(const LeafSystem& leaves, std::span<const Lanes> irradiance,
                 std::span<const double> escape, Exchange& exchange, RoundReport& report);

// What is absorbed on the way, W a channel: what more would arrive over the couplings that
// `without` has, from what leaves radiate in this solution. `bounces`: whether they reflect all
// they receive, or only what lights bring. One product and two reductions. For medium_w and
// glass_w, which AddEnergy counts.
Result<std::array<double, 3>> AbsorbedPower(const LeafSystem& leaves,
                                            std::span<const Lanes> irradiance, bool bounces,
                                            Transport& without, Exchange& exchange);

}  // namespace isolux
