// Which nodes of a worker take part in the products of a round, and which of other workers' nodes
// its links end at.
#pragma once

#include <cstdint>
#include <vector>

#include "common/util/status.h"
#include "worker/radiosity/exchange.h"
#include "worker/radiosity/placement.h"
#include "worker/radiosity/refine.h"
#include "worker/radiosity/tree.h"

namespace isolux {

// The nodes of a worker that take part in the products of one round.
struct ActiveNodes {
  std::vector<uint32_t> own;     // at and below own cut nodes, parents before children
  std::vector<uint32_t> leaves;  // those of `own` that end the tree
  std::vector<uint8_t> is_leaf;  // of `own`
  // Slots (slots.h).
  std::vector<uint32_t> exported;  // own ones others want, in the order of their ids
  std::vector<uint32_t> proxies;   // those wanted from others, home by home, by id
  // By own leaf: the same piece on the other side of a translucent sheet, or kNoNode; empty where
  // there are no sheets.
  std::vector<uint32_t> behind;
  // Of each cluster, by bits: the directions in which somebody needs its value.
  std::vector<uint16_t> directions;
};

// Tells the other workers which of their nodes the links here end at, makes those of our own that
// they name, and lists the nodes of the round. The leaves are the union of what all blocks ask for,
// and of `asked`, own nodes that lights ask for; of sheets both sides have the same.
Result<ActiveNodes> Subscribe(Tree& tree, Placement& placement, const LinkSet& links,
                              std::span<const uint32_t> asked, Exchange& exchange);

// The leaves of the installed snapshot that are homed here: to ask for them keeps them leaves.
std::vector<uint32_t> OwnLeaves(const Tree& tree, const Placement& placement);

}  // namespace isolux
