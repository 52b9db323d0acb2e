// What a job of one worker gathers at its end, without mesh or messages (server/job.cc).
#pragma once

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "server/source_gather.h"
#include "worker/shard.h"

namespace isolux::testing {

// Gathers at the middles of all leaves of the snapshot that is installed, then from these at the
// corners wanted of the elements. The snapshot is installed again afterwards.
inline Result<GatherPart> GatherOutput(Shard& shard, const Hierarchy& hierarchy,
                                       const Snapshot& snapshot,
                                       const std::vector<NodeId>& elements,
                                       const std::vector<uint8_t>& corners, double accuracy) {
  std::vector<NodeId> leaves;
  for (const LeafRecord& leaf : snapshot.leaves) leaves.push_back(leaf.id);
  ASSIGN_OR_RETURN(const GatherPart middles,
                   shard.Gather(leaves, std::vector<uint8_t>(leaves.size(), kCentre), accuracy));
  Snapshot sources = snapshot;
  for (size_t i = 0; i < leaves.size(); ++i) {
    for (size_t c = 0; c < 3; ++c) {
      const int64_t sum = std::max<int64_t>(0, middles.sums[12 * i + c]);
      sources.leaves[i].irradiance[c] = std::ldexp(static_cast<double>(sum), -middles.exponent);
    }
  }
  std::vector<uint32_t> all(snapshot.leaves.size());
  std::iota(all.begin(), all.end(), 0U);
  KeepReflectedPower(hierarchy, OutputMeshOptions(), snapshot, all, &sources);
  RETURN_IF_ERROR(shard.InstallSnapshot(sources));
  ASSIGN_OR_RETURN(GatherPart part, shard.Gather(elements, corners, accuracy));
  RETURN_IF_ERROR(shard.InstallSnapshot(snapshot));
  return part;
}

}  // namespace isolux::testing
