// The tree as a worker holds it: clusters, surfaces, and the elements that the last snapshot or
// links of the current round have made, with the values that refinement judges links by.
//
// Indices are this process's own and change when a snapshot is installed; ids never do. Clusters
// come first, by number; then the surfaces, by number; then elements, siblings side by side.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/hierarchy/hierarchy.h"
#include "common/hierarchy/mirrors.h"
#include "common/hierarchy/passed_light.h"
#include "common/hierarchy/snapshot.h"
#include "common/util/status.h"
#include "worker/coupling/coupling.h"
#include "worker/radiosity/cluster_facing.h"

namespace isolux {

inline constexpr uint32_t kNoNode = 0xffffffffu;

struct Node {
  NodeId id;
  uint32_t parent = kNoNode;
  uint32_t first_child = kNoNode;  // elements: two, side by side; clusters: see Tree::Children
};

// What a link is judged by: of the round's start, W/m², radiosities summed over the channels.
struct NodeValues {
  float radiosity = 0;  // area mean
  float spread = 0;     // largest minus smallest radiosity below
  float deviation = 0;  // area-weighted root mean square deviation of the radiosity below
};

class Tree {
 public:
  // Only clusters and surfaces. Keeps a pointer to the hierarchy.
  explicit Tree(const Hierarchy& hierarchy);

  const Hierarchy& hierarchy() const { return *hierarchy_; }
  size_t size() const { return nodes_.size(); }
  const Node& node(uint32_t index) const { return nodes_[index]; }
  const NodeValues& values(uint32_t index) const { return values_[index]; }
  double area_m2(uint32_t index) const { return area_m2_[index]; }
  // Geometry of a surface or element.
  const ConvexPolygon& polygon(uint32_t index) const { return polygons_[index - cluster_count_]; }
  double radius_m(uint32_t index) const { return radius_m_[index - cluster_count_]; }
  bool is_cluster(uint32_t index) const { return index < cluster_count_; }
  const Cluster& cluster(uint32_t index) const { return hierarchy_->clusters()[index]; }
  const Surface& surface_of(uint32_t index) const {
    return hierarchy_->surfaces()[nodes_[index].id.surface];
  }
  Vec3 normal(uint32_t index) const { return normals_[nodes_[index].id.surface]; }
  // Of the area of an element, of the bounds of a cluster.
  Vec3 centre(uint32_t index) const {
    return is_cluster(index) ? cluster(index).bounds.Centre() : centres_[index - cluster_count_];
  }
  // Of an element, as an end of a coupling. Good until the tree grows.
  CouplingEnd end(uint32_t index) const {
    return {&polygon(index), normal(index), centre(index), area_m2(index), radius_m(index)};
  }
  const ClusterFacing& facing() const { return facing_; }
  // Keeps the components of the scene apart in clusters: see ClusterFacing. To be called before
  // there are links.
  void SetComponents(std::span<const uint32_t> component_of) {
    facing_ = ClusterFacing(*hierarchy_, component_of, sheets_);
  }

  // The images that nodes see each other by; null: no mirrors. To be set before there are links.
  const Mirrors* mirrors() const { return mirrors_; }
  void SetMirrors(const Mirrors* mirrors) { mirrors_ = mirrors; }

  // The sheets that pass light on; null: none. To be set before components and values.
  const TranslucentSheets* sheets() const { return sheets_; }
  const Fluorescence* fluorescence() const { return fluorescence_; }  // likewise
  void SetPassing(const TranslucentSheets* sheets, const Fluorescence* fluorescence) {
    sheets_ = sheets->empty() ? nullptr : sheets;
    fluorescence_ = fluorescence->empty() ? nullptr : fluorescence;
  }
  // What leaves of a snapshot radiate beyond E + ρH; empty where they never do.
  std::vector<PassedLight> PassedLightOf(const Snapshot& snapshot) const {
    return isolux::PassedLightOf(snapshot, sheets_, fluorescence_);
  }

  uint32_t SurfaceIndex(uint32_t surface) const { return cluster_count_ + surface; }
  // Index of a node, or kNoNode where it does not exist.
  uint32_t Find(const NodeId& id) const;
  // Index of the deepest existing node that is `id` or above it. `id` is an element or surface.
  uint32_t FindNearest(const NodeId& id) const;
  // Makes the node, its sibling and those above where they do not exist.
  uint32_t FindOrMake(const NodeId& id);
  // First of the two children of an element, made where there were none: they take the values of
  // their parent, spread and deviation a factor 2^-1/2 smaller.
  uint32_t MakeChildren(uint32_t element);

  // Calls visit(index) for each child that exists.
  template <typename Visit>
  void ForEachChild(uint32_t index, Visit&& visit) const;

  // Rebuilds the elements to exactly those of the snapshot and pulls its values up. `moved[i]` is
  // the new index of the node that was i, or kNoNode where it is gone.
  Status Install(const Snapshot& snapshot, std::vector<uint32_t>* moved);
  // Place in the snapshot's leaves of the first leaf at or below a surface or element.
  uint32_t first_leaf(uint32_t index) const { return first_leaf_[index]; }
  // Nodes with a lower index come from the snapshot.
  size_t installed() const { return first_leaf_.size(); }

  uint64_t memory_bytes() const;

 private:
  void Reset();
  uint32_t Append(const NodeId& id, uint32_t parent, const ConvexPolygon& polygon);
  void InsertLeaves(const Snapshot& snapshot);
  void PullValues(const Snapshot& snapshot);

  const Hierarchy* hierarchy_;
  const Mirrors* mirrors_ = nullptr;
  const TranslucentSheets* sheets_ = nullptr;
  const Fluorescence* fluorescence_ = nullptr;
  uint32_t cluster_count_ = 0;
  std::vector<Vec3> normals_;  // of surfaces
  ClusterFacing facing_;
  // Side by side, by index.
  std::vector<Node> nodes_;
  std::vector<NodeValues> values_;
  std::vector<double> area_m2_;
  std::vector<uint32_t> first_leaf_;     // of installed nodes
  std::vector<ConvexPolygon> polygons_;  // without the clusters, as the next two
  std::vector<Vec3> centres_;            // of the area
  std::vector<double> radius_m_;         // about the centre
};

template <typename Visit>
void Tree::ForEachChild(uint32_t index, Visit&& visit) const {
  if (is_cluster(index)) {
    const Cluster& c = cluster(index);
    for (uint32_t i = 0; i < c.child_count; ++i) visit(c.first_child + i);
    if (c.child_count == 0) {
      for (uint32_t i = 0; i < c.surface_count; ++i) {
        visit(SurfaceIndex(hierarchy_->surface_order()[c.first_surface + i]));
      }
    }
  } else if (nodes_[index].first_child != kNoNode) {
    visit(nodes_[index].first_child);
    visit(nodes_[index].first_child + 1);
  }
}

}  // namespace isolux
