// What a round has made, looked at once its snapshot is installed and before the next threshold is
// chosen: the errors of the links by the values of now, and a sample of the gather, from which
// follow its own error and what gathering the whole output would take.
#pragma once

#include "common/hierarchy/hierarchy.h"
#include "common/hierarchy/snapshot.h"
#include "common/scene/solve_options.h"
#include "server/crew.h"
#include "server/output_mesh.h"

namespace isolux {

// Over all workers.
Result<LinkErrors> CountLinkErrors(Crew& crew);

// A seeded sample of leaves, each with the number of leaves that it stands for: half of the chances
// go to all leaves alike, half by area.
struct LeafSample {
  std::vector<uint32_t> leaves;  // places in the snapshot, in order
  std::vector<double> weight;
};
LeafSample SampleLeaves(const Hierarchy& hierarchy, const Snapshot& snapshot, uint64_t seed);

// Fills the row's error_gather and output_…. `output`: as the output of this round would be made.
Status SampleGather(Crew& crew, const Hierarchy& hierarchy, const Snapshot& snapshot,
                    const OutputMeshOptions& output, uint64_t seed, RoundSummary* row);

}  // namespace isolux
