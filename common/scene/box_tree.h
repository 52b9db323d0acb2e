// A tree of axis-aligned boxes that finds the boxes meeting a given one in logarithmic time and the
// number found. For the preparation of scenes, where every polygon asks for its neighbours.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/vec.h"

namespace isolux {

inline bool Overlap(const Bounds3& a, const Bounds3& b) {
  return a.low.x <= b.high.x && b.low.x <= a.high.x && a.low.y <= b.high.y && b.low.y <= a.high.y &&
         a.low.z <= b.high.z && b.low.z <= a.high.z;
}

inline Bounds3 Widened(const Bounds3& box, double by) {
  return {box.low - Vec3(by), box.high + Vec3(by)};
}

class BoxTree {
 public:
  explicit BoxTree(std::span<const Bounds3> boxes);

  // Calls found(number) for every box that meets `box`, in an order that depends on the boxes
  // alone.
  template <typename Found>
  void ForEachOverlap(const Bounds3& box, const Found& found) const {
    if (!nodes_.empty()) Visit(0, box, found);
  }

 private:
  struct Node {
    Bounds3 bounds;
    uint32_t begin = 0, end = 0;  // in order_; of a leaf
    uint32_t second = 0;          // the first child comes right after its parent; 0: a leaf
  };

  void Build(std::span<const Bounds3> boxes, uint32_t begin, uint32_t end);

  template <typename Found>
  void Visit(uint32_t n, const Bounds3& box, const Found& found) const {
    const Node& node = nodes_[n];
    if (!Overlap(node.bounds, box)) return;
    if (node.second != 0) {
      Visit(n + 1, box, found);
      Visit(node.second, box, found);
      return;
    }
    for (uint32_t i = node.begin; i < node.end; ++i) {
      if (Overlap(boxes_[i], box)) found(order_[i]);
    }
  }

  std::vector<Node> nodes_;
  std::vector<uint32_t> order_;
  std::vector<Bounds3> boxes_;  // in this order
};

}  // namespace isolux
