// Names of the nodes of the hierarchy, the same in every process.
//
//   element  (surface, path)   path 1 is the whole surface; children of path n are 2n and 2n+1
//   cluster  (kCluster, n)     n: number of the cluster in the hierarchy, the root is 0; where the
//                              value of a cluster is meant, as it is seen from one of kDirections,
//                              the direction stands in the high half
#pragma once

#include <bit>
#include <compare>
#include <cstdint>

namespace isolux {

struct NodeId {
  static constexpr uint32_t kCluster = 0xffffffffu;

  uint32_t surface = 0;
  uint64_t path = 1;

  bool is_cluster() const { return surface == kCluster; }
  bool is_surface() const { return !is_cluster() && path == 1; }
  NodeId Child(int which) const { return {surface, 2 * path + static_cast<uint64_t>(which)}; }
  NodeId Parent() const { return {surface, path / 2}; }
  int level() const { return 63 - std::countl_zero(path); }  // of an element: 0 is the surface

  bool operator==(const NodeId&) const = default;
};

inline constexpr int kMaxLevel = 60;  // elements are never split below this level
inline constexpr int kDirections =
    14;  // that clusters are told apart by: worker/radiosity/cluster_facing.h

// Whether `ancestor` is `node` or lies above it; both elements of a surface.
inline bool Contains(const NodeId& ancestor, const NodeId& node) {
  if (ancestor.surface != node.surface || node.path < ancestor.path) return false;
  return (node.path >> (node.level() - ancestor.level())) == ancestor.path;
}

// The order of a walk through the tree, parents before children: surfaces by number, then paths as
// bit strings. Clusters come last, by number.
inline std::strong_ordering operator<=>(const NodeId& a, const NodeId& b) {
  if (a.surface != b.surface) return a.surface <=> b.surface;
  if (a.is_cluster()) return a.path <=> b.path;
  const uint64_t left = a.path << std::countl_zero(a.path);
  const uint64_t right = b.path << std::countl_zero(b.path);
  if (left != right) return left <=> right;
  return a.path <=> b.path;
}

}  // namespace isolux
