// What of a scene takes from light on its way, as a plan wants it.
#pragma once

#include <optional>
#include <span>

#include "common/hierarchy/panes.h"
#include "common/hierarchy/shard_data.h"
#include "common/scene/effects_plan.h"
#include "common/scene/scene.h"
#include "common/scene/solve_options.h"
#include "worker/radiosity/matvec.h"
#include "worker/radiosity/solver.h"

namespace isolux {

// Nothing where there is none. Of one channel in the place of three the mean counts.
std::optional<Medium> AbsorbingMedium(const Scene& scene, const EffectsPlan& plan);
std::optional<Panes> AbsorbingPanes(const Scene& scene, const EffectsPlan& plan, double extent_m);

// Gauss-Seidel and Southwell go through links one by one and know of neither.
Status CheckSolver(SolverMethod solver, bool medium, bool panes);

// Sets what the medium and the panes of `between` absorb, medium_w and glass_w, in this solution;
// see AbsorbedPower. The product is without them afterwards.
Status AddAbsorbedPower(const RefineScene& between, const LeafSystem& leaves,
                        std::span<const Lanes> irradiance, bool bounces, Product& product,
                        Exchange& exchange, RoundReport& report);

}  // namespace isolux
