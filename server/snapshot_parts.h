// The state of a solution as the workers hand it in, each its part.
#pragma once

#include "common/hierarchy/snapshot.h"
#include "server/crew.h"

namespace isolux {

// Waits for the parts of all workers and joins them; fails where they are not of this round.
Result<Snapshot> CollectSnapshot(Crew& crew, uint32_t surfaces, uint32_t round, double epsilon);

}  // namespace isolux
