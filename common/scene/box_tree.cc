#include "common/scene/box_tree.h"

#include <algorithm>
#include <numeric>

namespace isolux {
namespace {

constexpr uint32_t kLeafBoxes = 4;

}  // namespace

BoxTree::BoxTree(std::span<const Bounds3> boxes) : order_(boxes.size()) {
  std::iota(order_.begin(), order_.end(), 0U);
  if (!boxes.empty()) Build(boxes, 0, static_cast<uint32_t>(boxes.size()));
  boxes_.reserve(boxes.size());
  for (const uint32_t b : order_) boxes_.push_back(boxes[b]);
}

void BoxTree::Build(std::span<const Bounds3> boxes, uint32_t begin, uint32_t end) {
  const size_t n = nodes_.size();
  nodes_.push_back({{}, begin, end, 0});
  Bounds3 centres;
  for (uint32_t i = begin; i < end; ++i) {
    nodes_[n].bounds.Add(boxes[order_[i]]);
    centres.Add(boxes[order_[i]].Centre());
  }
  if (end - begin <= kLeafBoxes) return;
  const Vec3 extent = centres.Extent();
  const int axis =
      extent.x >= extent.y ? (extent.x >= extent.z ? 0 : 2) : (extent.y >= extent.z ? 1 : 2);
  const uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                   [&](uint32_t a, uint32_t b) {
                     const double x = boxes[a].low[axis] + boxes[a].high[axis];
                     const double y = boxes[b].low[axis] + boxes[b].high[axis];
                     return x != y ? x < y : a < b;
                   });
  Build(boxes, begin, middle);
  nodes_[n].second = static_cast<uint32_t>(nodes_.size());
  Build(boxes, middle, end);
}

}  // namespace isolux
