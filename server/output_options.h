// How fine the output of a job is to be.
#pragma once

#include "common/hierarchy/hierarchy.h"
#include "common/scene/effects_plan.h"
#include "common/scene/solve_options.h"
#include "server/output_mesh.h"

namespace isolux {

// After this round, of so many leaves. `accuracy`: asked for; `limits`: what the options must keep.
OutputMeshOptions OutputOptionsOf(const RoundSummary& last, double accuracy,
                                  const Hierarchy& hierarchy, const EffectsPlan& plan,
                                  uint64_t leaves, const OutputMeshOptions& limits);

}  // namespace isolux
