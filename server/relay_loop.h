// Keeps the collectives of a round going: takes one message of every worker, lets relay.h combine
// them, sends the replies, until the workers have something else to say.
#pragma once

#include <cstdint>
#include <functional>

#include "common/hierarchy/assignment.h"
#include "server/crew.h"

namespace isolux {

struct CollectiveNews {
  bool subscribed = false;  // refinement is over, solving has begun
  uint32_t products = 0;    // matrix products so far
};

// Returns the messages of kind `last` that end the round; any other that is no collective is an
// error. `news` (may be empty) is called as the round goes on.
Result<PerWorker<Message>> RelayUntil(Crew& crew, const Assignment& assignment, MessageKind last,
                                      const std::function<void(const CollectiveNews&)>& news);

}  // namespace isolux
