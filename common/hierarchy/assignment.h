// Who does what: the cut and the homes of its nodes. It assigns work and changes no bit of the
// answer.
#pragma once

#include <cstdint>
#include <vector>

#include "common/hierarchy/node_id.h"

namespace isolux {

// The cut is an antichain of nodes that covers all leaves: clusters, surfaces, or elements that
// exist in the last snapshot. Nodes above it are the crown; every worker keeps the crown.
struct Assignment {
  std::vector<NodeId> cut;     // sorted by NodeId
  std::vector<uint32_t> home;  // worker of each cut node, in [0, worker_count)
  uint32_t worker_count = 1;

  bool operator==(const Assignment&) const = default;
};

}  // namespace isolux
