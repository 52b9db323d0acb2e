// The own leaves' part of the next snapshot.
#pragma once

#include <span>
#include <vector>

#include "common/hierarchy/snapshot.h"
#include "worker/radiosity/error_estimate.h"
#include "worker/radiosity/solver.h"
#include "worker/radiosity/tree.h"

namespace isolux {

// What a round found of these leaves, nodes of the tree, in the order of their ids.
std::vector<LeafRecord> RecordLeaves(const Tree& tree, std::span<const uint32_t> nodes,
                                     const LeafSystem& leaves, std::span<const Lanes> irradiance,
                                     const ErrorEstimate& errors, std::span<const double> escape);

}  // namespace isolux
