// Light that translucent sheets pass from side to side, as an iteration around the solvers of
// B = E + ρH (solver.h): what is passed on, τH', stands beside the exitance of the side where it
// comes out; solved with that, the irradiances pass on something else, until that no longer changes
// what matters. One pass after the other converges for ρ + τ < 1, by a factor of τ/(1 − ρ) at
// worst; from the last few passes together it does so in a handful ([Anderson65], in Walker and
// Ni's form).
#pragma once

#include <span>
#include <vector>

#include "worker/radiosity/matvec.h"
#include "worker/radiosity/solver.h"
#include "worker/radiosity/transport.h"

namespace isolux {

// The irradiance at own leaves with what is passed on, where the product's tree has sheets or
// fluorescence; else what `solve` finds. `leaves` radiate what they emit themselves; what is left
// in the end counts in the result's residual. Same bits for any number of workers, where those of
// `solve` are. Fluorescence needs three channels.
template <typename V>
Result<SolverResultOf<V>> SolveWithPassedLight(Product& product, const LeafSystemOf<V>& leaves,
                                               std::type_identity_t<std::span<const V>> start,
                                               double accuracy, const SolveFunction<V>& solve,
                                               Exchange& exchange);

// Adds what this irradiance passes on to the exitance of the leaves; of it passed_on is set to what
// comes through sheets, which is no new light in its channel. Nothing where there is neither.
Status AddPassedLight(Product& product, std::span<const Lanes> irradiance, LeafSystem& leaves);

}  // namespace isolux
