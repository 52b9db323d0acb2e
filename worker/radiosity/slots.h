// Where the values of a product are kept: one place for an element, fourteen for a cluster, one a
// direction it is seen from.
#pragma once

#include "worker/radiosity/link.h"
#include "worker/radiosity/tree.h"

namespace isolux {

class Slots {
 public:
  explicit Slots(const Tree& tree)
      : cluster_count_(static_cast<uint32_t>(tree.hierarchy().clusters().size())) {}

  size_t count(const Tree& tree) const {
    return tree.size() + size_t{kDirections - 1} * cluster_count_;
  }
  uint32_t OfElement(uint32_t node) const { return node + (kDirections - 1) * cluster_count_; }
  uint32_t OfCluster(uint32_t cluster, int direction) const {
    return cluster * kDirections + static_cast<uint32_t>(direction);
  }
  bool is_cluster(uint32_t slot) const { return slot < cluster_count_ * kDirections; }
  uint32_t NodeOf(uint32_t slot) const {
    return is_cluster(slot) ? slot / kDirections : slot - (kDirections - 1) * cluster_count_;
  }
  int DirectionOf(uint32_t slot) const {
    return is_cluster(slot) ? static_cast<int>(slot % kDirections) : 0;
  }

  struct Ends {
    uint32_t p, q;
  };
  // Of what p and q, or p and an image of q, exchange: clusters as each sees the other end's
  // centre.
  Ends Of(const Tree& tree, uint32_t p, uint32_t q, const MirrorImage* through = nullptr) const {
    if (!tree.is_cluster(p) && !tree.is_cluster(q)) return {OfElement(p), OfElement(q)};
    const auto slot = [&](uint32_t node, int direction) {
      return tree.is_cluster(node) ? OfCluster(node, direction) : OfElement(node);
    };
    if (through == nullptr) {
      const int direction = NearestDirection(tree.centre(q) - tree.centre(p));
      return {slot(p, direction), slot(q, direction ^ 1)};
    }
    const Vec3 d = through->image.Point(tree.centre(q)) - tree.centre(p);
    return {slot(p, NearestDirection(d)), slot(q, NearestDirection(through->back.Direction(-d)))};
  }

  Ends Of(const Tree& tree, const Link& link) const {
    return Of(tree, link.p, link.q,
              link.through_mirrors() ? &tree.mirrors()->images()[link.image()] : nullptr);
  }

  // A slot as a name that is the same in every process; a cluster's direction stands in the high
  // half of the path.
  NodeId IdOf(const Tree& tree, uint32_t slot) const {
    if (!is_cluster(slot)) return tree.node(NodeOf(slot)).id;
    return {NodeId::kCluster,
            uint64_t{static_cast<uint32_t>(DirectionOf(slot))} << 32 | NodeOf(slot)};
  }
  // kNoNode where the name is not that of a slot of an existing node.
  uint32_t Find(const Tree& tree, const NodeId& id) const {
    if (!id.is_cluster()) {
      const uint32_t node = tree.Find(id);
      return node == kNoNode ? kNoNode : OfElement(node);
    }
    const uint64_t direction = id.path >> 32, cluster = id.path & 0xffffffffu;
    if (direction >= kDirections || cluster >= cluster_count_) return kNoNode;
    return OfCluster(static_cast<uint32_t>(cluster), static_cast<int>(direction));
  }

 private:
  uint32_t cluster_count_;
};

}  // namespace isolux
