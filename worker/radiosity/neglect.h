// What leaving an effect out would cost, from a solution that has it.
//
// With F what hands light from leaf to leaf when nothing takes it on the way, mirrors included, and
// K = ρ + τP what surfaces hand on, an effect brings S (or takes D) at places where light arrives,
// of power P in all; without it the irradiance differs by (I − FK)⁻¹ S. By reciprocity, A F is
// symmetric, Σ A ΔH = Σ A B S with B = 1 + K F B: the radiosity where every side emits 1. So
// Σ A |ΔH| ≤ P max B: wherever a watt of it arrives, no more than max B watts arrive in the end.
//
// P is measured: Σ k_s A H over mirrors, Σ τ A H over sheets, what of A H is reradiated, the power
// that the medium absorbs, and by pane_light.h what panes take. Effects that are left out together
// cost no more than the sum.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/hierarchy/hierarchy.h"
#include "common/hierarchy/shard_data.h"
#include "worker/radiosity/error_estimate.h"
#include "worker/radiosity/solver.h"

namespace isolux {

// Of each of `effects`, those that can be measured (common/hierarchy/effects/plan.h). `leaves` with
// what is passed on; `report` with what the medium absorbs. The product has neither medium nor
// panes. `solve`: one channel over this product. Mirrors that are not simulated, and
// lobes where gloss is asked for, count as if they reflected diffusely. The same at all workers;
// one solve, a product and three reductions.
Result<std::vector<MeasuredEffect>> MeasureNeglect(
    std::span<const std::string> effects, const Hierarchy& hierarchy, const LeafSystem& leaves,
    std::span<const Lanes> irradiance, const ErrorEstimate& errors, const RoundReport& report,
    Product& product, const SolveFunction<Single>& solve, Exchange& exchange);

// The largest radiosity of any leaf where each emits 1, over this product, or more. `unit`: leaves
// that do. From a solution b of whatever accuracy: where b − KFb ≥ 1/c everywhere, c b is no less
// than the exact one ([BermanPlemmons94], M-matrices). Infinite where there is no solution, or none
// to such an accuracy.
Result<double> LargestAmplification(Product& product, const LeafSystemOf<Single>& unit,
                                    double accuracy, const SolveFunction<Single>& solve,
                                    Exchange& exchange);

}  // namespace isolux
