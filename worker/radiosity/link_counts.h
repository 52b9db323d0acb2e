// What a round's links come to at one worker: figures for the report, and loads to balance by.
#pragma once

#include "common/hierarchy/shard_data.h"
#include "worker/radiosity/placement.h"
#include "worker/radiosity/refine.h"
#include "worker/radiosity/subscribe.h"
#include "worker/radiosity/tree.h"

namespace isolux {

// Fills in the report's counts of links, leaves and evaluations, over all and by node of the cut,
// and lays the seconds of refinement and solution on these nodes: by evaluations and by links.
// Links of the crown, which every worker has, count at their homes; all enter the crown's hash.
void CountLinks(const Tree& tree, const Placement& placement, const LinkSet& links,
                const ActiveNodes& nodes, const RefineCounters& counters, double refine_cpu_s,
                double solve_cpu_s, RoundReport& report);

}  // namespace isolux
