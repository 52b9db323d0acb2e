// Links that change their home. After a snapshot is installed the trees of all workers are equal,
// index by index, so links travel as they are.
#pragma once

#include <string>
#include <vector>

#include "common/hierarchy/shard_data.h"
#include "common/util/status.h"
#include "worker/radiosity/placement.h"
#include "worker/radiosity/refine.h"
#include "worker/radiosity/tree.h"

namespace isolux {

// Takes out of the links those that the placement, which is new, has at home elsewhere.
std::vector<MigrationParcel> TakeLeaving(const Placement& now, LinkSet* links);

// Adds the links of a parcel.
Status AbsorbParcel(const std::string& bytes, const Tree& tree, const Placement& placement,
                    LinkSet* links);

}  // namespace isolux
