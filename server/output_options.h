// How fine the output of a job is to be.
#pragma once

#include "common/hierarchy/hierarchy.h"
#include "common/scene/effects_plan.h"
#include "common/scene/solve_options.h"
#include "server/output_mesh.h"

namespace isolux {

// After this round, of so many leaves. `asked`: of the job; `limits`: what the options must keep.
OutputMeshOptions OutputOptionsOf(const RoundSummary& last, const SolveOptions& asked,
                                  const Hierarchy& hierarchy, const EffectsPlan& plan,
                                  uint64_t leaves, const OutputMeshOptions& limits);

// For coarser accuracies rays at points become no fewer (GatherOptionsFor).
inline constexpr double kCoarsestOfPoints = 0.0632;

// What accuracy rays at points can work to that may take so many times as long as at `accuracy`:
// rays, of which more follow where the first disagree, go with its power -1.25, from
// kCoarsestOfPoints on. Not less than a third of that: beyond it points hardly gain.
double PointAccuracyWithin(double times_as_long, double accuracy);

}  // namespace isolux
