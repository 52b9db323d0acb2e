// A tree of axis-aligned boxes that finds the boxes meeting a given one in logarithmic time and the
// number found. For the preparation of scenes, where every polygon asks for its neighbours.
#pragma once

#include <algorithm>
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

// Whether a segment meets a box; inverse: of its extent along each axis.
inline bool Meets(const Bounds3& box, const Vec3& from, const Vec3& inverse) {
  double first = 0, last = 1;
  for (int c = 0; c < 3; ++c) {
    const double a = (box.low[c] - from[c]) * inverse[c];
    const double b = (box.high[c] - from[c]) * inverse[c];
    // What is no number, of a segment within a side of the box, leaves both as they are.
    first = std::max(first, std::min(a, b));
    last = std::min(last, std::max(a, b));
  }
  return first <= last;
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

  // The same for every box that a segment meets.
  template <typename Found>
  void ForEachAlong(const Vec3& from, const Vec3& to, const Found& found) const {
    if (!nodes_.empty()) VisitAlong(0, from, 1.0 / (to - from), found);
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

  template <typename Found>
  void VisitAlong(uint32_t n, const Vec3& from, const Vec3& inverse, const Found& found) const {
    const Node& node = nodes_[n];
    if (!Meets(node.bounds, from, inverse)) return;
    if (node.second != 0) {
      VisitAlong(n + 1, from, inverse, found);
      VisitAlong(node.second, from, inverse, found);
      return;
    }
    for (uint32_t i = node.begin; i < node.end; ++i) {
      if (Meets(boxes_[i], from, inverse)) found(order_[i]);
    }
  }

  std::vector<Node> nodes_;
  std::vector<uint32_t> order_;
  std::vector<Bounds3> boxes_;  // in this order
};

}  // namespace isolux
