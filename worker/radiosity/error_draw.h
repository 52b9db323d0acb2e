// What the errors of links do to rooms that hardly lose light. There what one leaf gets too much
// and another lacks is not soon lost in what all get: rooms that a small hole joins share light as
// the few links through it say, and pass it on a thousand times. EstimateError takes such errors
// for even at once where rows are closed, and sees none.
#pragma once

#include <span>

#include "common/util/status.h"
#include "worker/radiosity/exchange.h"
#include "worker/radiosity/matvec.h"
#include "worker/radiosity/solver.h"

namespace isolux {

// Rooms whose λ is above this are looked at so: others lose light faster than they could pass it
// from part to part.
inline constexpr double kPassesOnErrors = 0.95;

// By draws: every coupling is off by its expected error, up or down by chance that follows from its
// link alone, and what it exchanges, B_q − B_p, by as much; power is neither made nor lost. All
// that comes of it is solved for. Mean |ΔH| of what is reflected of these errors, over mean H: root
// mean square of four draws, in two solutions. `leaves`: as they were solved, of neither sheets nor
// fluorescence.
Result<double> DrawError(Product& product, const Tree& tree, const LeafSystem& leaves,
                         std::span<const Lanes> irradiance, const SolveFunction<Lanes>& solve,
                         Exchange& exchange);

}  // namespace isolux
