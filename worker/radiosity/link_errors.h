// The errors of a worker's links, by the values that its tree holds now.
#pragma once

#include "common/hierarchy/shard_data.h"
#include "worker/radiosity/refine.h"

namespace isolux {

// Of the links homed here; those of the crown are everybody's, and counted by one.
ErrorHistogram CountErrors(const Tree& tree, const Placement& placement, const LinkSet& links,
                           ThreadPool& pool);

}  // namespace isolux
