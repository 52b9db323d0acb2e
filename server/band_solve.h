// Spectral bands (common/scene/bands.h), once the last round is over and the mesh of the output is
// known: for each group of three the workers solve over the links as they are, and gather at the
// points of the mesh.
#pragma once

#include <cstdint>
#include <functional>

#include "common/hierarchy/assignment.h"
#include "common/hierarchy/hierarchy.h"
#include "common/hierarchy/snapshot.h"
#include "common/scene/effects_plan.h"
#include "common/scene/solve_options.h"
#include "server/crew.h"
#include "server/gather_waves.h"
#include "server/output_mesh.h"

namespace isolux {

struct BandsInput {
  const Hierarchy& hierarchy;  // with the channels
  const Snapshot& snapshot;    // of the last round
  const EffectsPlan& plan;
  const OutputMeshOptions& output;  // of the mesh
  double accuracy;                  // asked for
  std::array<double, 3> emitted_w;  // of the last round, what is reradiated included
};

// As it goes on: which group, from 0, and matrix products or output elements of it so far.
using BandNews = std::function<void(uint32_t group, uint32_t products, uint64_t gathered)>;

// Puts the bands into the mesh's patch file, and their sums in the place of its channels (of
// `error` too), and says in the summary what became of them: also in its last round, whose error
// estimate, residual and imbalance are those of the channels or of the bands, whichever are larger.
Status SolveBands(Crew& crew, const Assignment& assignment, const BandsInput& input,
                  GatherWaves& waves, const BandNews& news, OutputMesh* mesh,
                  SolveSummary* summary);

// The error of several groups together: of each Σ A |ΔH| over Σ A H.
double ErrorOfAll(const std::vector<BandGroupSummary>& groups);

}  // namespace isolux
