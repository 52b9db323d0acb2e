// The cut and the homes of its nodes: which parts of the tree exist to be given to workers, and who
// gets them at the start. Pure functions; nothing here changes a bit of the answer.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/hierarchy/assignment.h"
#include "common/hierarchy/hierarchy.h"
#include "common/hierarchy/snapshot.h"
#include "common/scene/solve_options.h"

namespace isolux {

inline constexpr uint32_t kCutNodesPerWorker = 8;  // at least, where the scene has them

// Nodes the cut should have.
uint32_t CutTarget(const SolveOptions& options, uint32_t worker_count);

// By what a node of the cut may be replaced in it, in order; empty where it has no children that
// hold surfaces. Elements have children where the snapshot (may be null) has leaves below them.
std::vector<NodeId> ChildrenOf(const Hierarchy& hierarchy, const Snapshot* snapshot,
                               const NodeId& node);

// Leaves of the snapshot below a node of the cut.
uint64_t CountLeaves(const Hierarchy& hierarchy, const Snapshot& snapshot, const NodeId& node);

// Area of the surfaces below, m², both sides counted.
double AreaOf(const Hierarchy& hierarchy, const NodeId& node);

// An antichain of clusters and surfaces that covers every surface: the heaviest node is replaced by
// its children until there are `target` or nothing is left to split. Half of a node's weight is its
// share of the area, half its share of the surfaces: the first links are pairs of surfaces, later
// ones go by area.
std::vector<NodeId> MakeCut(const Hierarchy& hierarchy, uint32_t target);

// Homes of the cut's nodes:
//   octree    consecutive pieces of equal weight in the order of the octree
//   input     the same in the order of the scene's surfaces
//   random    the same in an order drawn from the seed
//   balanced  heaviest first, each to the worker with the least weight so far
std::vector<uint32_t> AssignHomes(const Hierarchy& hierarchy, std::span<const NodeId> cut,
                                  Distribution distribution, uint32_t worker_count, uint64_t seed);

Assignment Partition(const Hierarchy& hierarchy, const SolveOptions& options,
                     uint32_t worker_count);

}  // namespace isolux
