// What the coordinator makes of the workers' reports: the row of a round, and the comments of the
// patch file. Pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/hierarchy/assignment.h"
#include "common/hierarchy/effects/plan.h"
#include "common/hierarchy/shard_data.h"
#include "common/scene/scene.h"
#include "common/scene/solve_options.h"
#include "common/util/status.h"
#include "server/balance.h"
#include "server/relay.h"
#include "server/source_gather.h"
#include "server/traffic.h"

namespace isolux {

// The row of a round from the reports of all workers; times and bytes that the coordinator alone
// knows are left 0. Fails where workers disagree on what must be equal at all of them: the crown's
// links and the collective figures.
Result<RoundSummary> MergeReports(const PerWorker<RoundReport>& reports, uint32_t round);

// Loads of the cut's nodes, each as its home reported it.
Result<CutLoads> MergeLoads(const PerWorker<RoundReport>& reports, const Assignment& assignment);

// What effects took of the rounds and the gather; links as the last round has them.
EffectCosts TotalCosts(std::span<const RoundSummary> rounds, const EffectCosts& gather);

// What the output showed, into the row of the last round and its estimate: what interpolation
// leaves, and light that the links missed, which the row has already.
void AddOutputErrors(double interpolation_error, RoundSummary* last);

// What was asked of a job.
struct Asked {
  const std::string& name;  // of the scene, for people; may be empty
  const Scene& scene;
  const std::string& scene_hash;
  const SolveOptions& options;
  const EffectsTable& effects;
};

// `comment isolux KEY VALUE` lines of the patch file: what was asked, what was reached, one line an
// effect and a round, bytes by phase, and by connection and phase.
std::vector<std::pair<std::string, std::string>> MakeComments(const Asked& asked,
                                                              const SolveSummary& summary,
                                                              const Traffic& traffic);

}  // namespace isolux
