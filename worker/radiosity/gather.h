// Irradiance at output points, through the links: coarse transport, fine output.
//
//   H(x) = Σ over links of the leaf and of all above it:  V(x, q) B_q F(x→q), and what lights bring
// with F in closed form at the point, sources opened where they carry much and vary, and V from the
// link where that is sure of it. Of a source in doubt V is found by rays: at first in
// proportion to what it brings and to the doubt of its link, and more where these disagree.
//
// A link's rays at a point follow from the link, the snapshot and a seed alone, so it does not
// matter which worker holds the link.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "common/hierarchy/shard_data.h"
#include "worker/radiosity/light_field.h"
#include "worker/radiosity/matvec.h"

namespace isolux {

struct GatherOptions {
  // A source gets rays in proportion to what it brings and to the doubt of its link: one where the
  // product is this share of the leaf's irradiance, all sources together about so many a point.
  double ray_share = 2e-3;
  double most_rays = 64;
  // Where rays to a source disagree more follow, until the point is off by no more than this share
  // of the leaf's irradiance.
  double point_error = 3e-3;
  // A source that brings less than this share of a leaf's irradiance is taken to be the same all
  // over the leaf: many such vary against each other.
  double even_share = 2e-4;
  // A source that brings more than this share, and varies, is opened.
  double open_share = 0.02;
  uint64_t seed = 1;
};

// For an accuracy of the irradiance.
GatherOptions GatherOptionsFor(double accuracy, uint64_t seed);

// Made once a snapshot; keeps references to all it is given.
class Gatherer {
 public:
  // `lights`: null where there are none. Of lights each worker adds what reaches its own leaves.
  // `between`: what made the links, with the medium and the panes.
  Gatherer(const Tree& tree, const Placement& placement, const LinkSet& links,
           const Snapshot& snapshot, const RayScene& rays, const LightField* lights,
           const RefineScene& between);
  ~Gatherer();

  // `elements`: sorted, leaves of the snapshot the tree was installed from, or below them.
  // `corners`: of each the corners wanted, by bits, or kCentre; empty: all. Counts only the links
  // homed here.
  Result<GatherPart> AtCorners(std::span<const NodeId> elements, std::span<const uint8_t> corners,
                               const GatherOptions& options, ThreadPool& pool) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace isolux
