// Irradiance at output points, through the links: coarse transport, fine output.
//
//   H(x) = Σ over links of the leaf and of all above it:  V(x, q) B_q F(x→q)
// with F in closed form at the point, sources opened where they carry much and vary, and V from
// rays at the point for the links that matter and are in doubt, from the link otherwise.
//
// A link's rays at a point follow from the link, the snapshot and a seed alone, so it does not
// matter which worker holds the link.
#pragma once

#include <vector>

#include "common/hierarchy/shard_data.h"
#include "worker/radiosity/matvec.h"

namespace isolux {

struct GatherOptions {
  int rays = 64;  // about so many a point, shared out by what each link brings and its doubt
  // A source that brings less than this share of a leaf's irradiance is taken to be the same all
  // over the leaf: many such vary against each other.
  double even_share = 2e-4;
  // A source that brings more than this share, and varies, is opened.
  double open_share = 0.02;
  uint64_t seed = 1;
};

// `elements`: sorted, leaves of the snapshot the tree was installed from, or below them. Counts
// only the links homed here.
Result<GatherPart> GatherAtCorners(const std::vector<NodeId>& elements, const Tree& tree,
                                   const Placement& placement, const LinkSet& links,
                                   const Snapshot& snapshot, const RayScene& rays,
                                   const GatherOptions& options, ThreadPool& pool);

}  // namespace isolux
