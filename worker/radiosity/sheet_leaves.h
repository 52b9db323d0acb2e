// The two sides of translucent sheets as leaves of a round: both are divided alike, and each own
// leaf finds the same piece on the other side, wherever that is at home.
#pragma once

#include <span>
#include <vector>

#include "common/util/status.h"
#include "worker/radiosity/exchange.h"
#include "worker/radiosity/placement.h"
#include "worker/radiosity/subscribe.h"
#include "worker/radiosity/tree.h"

namespace isolux {

// Of every element of a sheet that somebody here asks for (`ends`, by tree index) or that the cut
// names, asks for the same piece of the other side: of our own by `ends`, of others by `wanted`.
// Done by all workers, it makes the leaves of both sides the same pieces.
void AskBehind(Tree& tree, Placement& placement, std::vector<uint8_t>& ends,
               std::vector<std::vector<NodeId>>& wanted);

// Subscribes anew to `wanted` and to the leaves behind own leaves, and fills in where those are
// kept: ActiveNodes::behind, exported and proxies.
Status SubscribeBehind(Tree& tree, Placement& placement, std::vector<std::vector<NodeId>> wanted,
                       Exchange& exchange, ActiveNodes& nodes);

}  // namespace isolux
