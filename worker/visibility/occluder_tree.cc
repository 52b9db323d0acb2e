#include "worker/visibility/occluder_tree.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>

#include "common/util/check.h"

namespace isolux {
namespace {

// What Embree's builder hands us: nodes in its own memory, flattened right after.
struct BuiltNode {
  BuiltNode* child[2] = {nullptr, nullptr};
  std::array<uint32_t, 4> occluders{};
  uint32_t count = 0;  // 0: has children
};

void* CreateNode(RTCThreadLocalAllocator allocator, unsigned, void*) {
  return new (rtcThreadLocalAlloc(allocator, sizeof(BuiltNode), 16)) BuiltNode;
}
void SetChildren(void* node, void** children, unsigned count, void*) {
  CHECK(count == 2);
  for (int i = 0; i < 2; ++i) {
    static_cast<BuiltNode*>(node)->child[i] = static_cast<BuiltNode*>(children[i]);
  }
}
void IgnoreBounds(void*, const RTCBounds**, unsigned, void*) {}
void* CreateLeaf(RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* primitives,
                 size_t count, void*) {
  auto* leaf = new (rtcThreadLocalAlloc(allocator, sizeof(BuiltNode), 16)) BuiltNode;
  leaf->count = static_cast<uint32_t>(count);
  for (size_t i = 0; i < count; ++i) leaf->occluders[i] = primitives[i].primID;
  return leaf;
}

std::vector<RTCBuildPrimitive> Primitives(const OccluderSet& set) {
  std::vector<RTCBuildPrimitive> primitives(set.size());
  for (uint32_t i = 0; i < set.size(); ++i) {
    const Bounds3& box = set[i].bounds;
    primitives[i] = {static_cast<float>(box.low.x),  static_cast<float>(box.low.y),
                     static_cast<float>(box.low.z),  0,
                     static_cast<float>(box.high.x), static_cast<float>(box.high.y),
                     static_cast<float>(box.high.z), i};
  }
  return primitives;
}

}  // namespace

OccluderTree::OccluderTree(const OccluderSet& set) : set_(&set) {
  if (set.size() == 0) return;
  RTCDevice device = rtcNewDevice("isa=avx2,threads=1,frequency_level=simd256");
  CHECK(device != nullptr);
  RTCBVH bvh = rtcNewBVH(device);
  std::vector<RTCBuildPrimitive> primitives = Primitives(set);
  RTCBuildArguments arguments = rtcDefaultBuildArguments();
  arguments.buildQuality = RTC_BUILD_QUALITY_MEDIUM;
  arguments.maxBranchingFactor = 2;
  arguments.minLeafSize = 1;
  arguments.maxLeafSize = 4;
  arguments.bvh = bvh;
  arguments.primitives = primitives.data();
  arguments.primitiveCount = primitives.size();
  arguments.primitiveArrayCapacity = primitives.size();
  arguments.createNode = CreateNode;
  arguments.setNodeChildren = SetChildren;
  arguments.setNodeBounds = IgnoreBounds;
  arguments.createLeaf = CreateLeaf;
  const auto* root = static_cast<const BuiltNode*>(rtcBuildBVH(&arguments));
  CHECK(root != nullptr);

  std::vector<const BuiltNode*> built{root};  // beside nodes_
  nodes_.resize(1);
  for (size_t n = 0; n < built.size(); ++n) {
    const BuiltNode& from = *built[n];
    nodes_[n].count = from.count;
    if (from.count == 0) {
      nodes_[n].first = static_cast<uint32_t>(nodes_.size());
      nodes_.resize(nodes_.size() + 2);
      built.insert(built.end(), {from.child[0], from.child[1]});
      continue;
    }
    nodes_[n].first = static_cast<uint32_t>(order_.size());
    for (uint32_t i = 0; i < from.count; ++i) {
      order_.push_back(from.occluders[i]);
      nodes_[n].bounds.Add(set[from.occluders[i]].bounds);
    }
  }
  for (size_t n = nodes_.size(); n-- > 0;) {  // children after parents
    if (nodes_[n].count > 0) continue;
    nodes_[n].bounds.Add(nodes_[nodes_[n].first].bounds);
    nodes_[n].bounds.Add(nodes_[nodes_[n].first + 1].bounds);
  }
  rtcReleaseBVH(bvh);
  rtcReleaseDevice(device);
}

template <typename Touches, typename Leaf>
void OccluderTree::Visit(const Touches& touches, const Leaf& leaf) const {
  if (nodes_.empty()) return;
  // Embree builds no deeper than 32 levels by default, and each level leaves one node waiting.
  std::array<uint32_t, 64> stack;
  int size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const Node& node = nodes_[stack[--size]];
    if (!touches(node.bounds)) continue;
    if (node.count == 0) {
      stack[size++] = node.first + 1;
      stack[size++] = node.first;
      continue;
    }
    for (uint32_t i = 0; i < node.count; ++i) {
      if (!leaf(order_[node.first + i])) return;
    }
  }
}

Verdict OccluderTree::Settle(const Shaft& shaft, std::vector<uint32_t>* candidates) const {
  return SettleShort(shaft, set_->size(), candidates);
}

Verdict OccluderTree::SettleShort(const Shaft& shaft, size_t most,
                                  std::vector<uint32_t>* candidates) const {
  candidates->clear();
  bool blocked = false;
  Visit([&](const Bounds3& box) { return shaft.MayTouch(box); },
        [&](uint32_t occluder) {
          const Verdict verdict = shaft.Classify(*set_, (*set_)[occluder]);
          if (verdict == Verdict::kPartial) candidates->push_back(occluder);
          blocked = verdict == Verdict::kBlocks;
          return !blocked && candidates->size() <= most;
        });
  if (blocked) return Verdict::kBlocks;
  std::sort(candidates->begin(), candidates->end());
  return candidates->empty() ? Verdict::kOutside : Verdict::kPartial;
}

Verdict OccluderTree::Settle(const Shaft& shaft, std::span<const uint32_t> parent,
                             std::vector<uint32_t>* candidates) const {
  if (parent.size() > kLongList) return Settle(shaft, candidates);
  candidates->clear();
  if (shaft.Filter(*set_, parent, candidates)) return Verdict::kBlocks;
  return candidates->empty() ? Verdict::kOutside : Verdict::kPartial;
}

std::vector<uint32_t> OccluderTree::Candidates(const BoxShaft& shaft) const {
  std::vector<uint32_t> candidates;
  Visit([&](const Bounds3& box) { return shaft.MayTouch(box); },
        [&](uint32_t occluder) {
          if (shaft.MayBlock(*set_, (*set_)[occluder])) candidates.push_back(occluder);
          return true;
        });
  std::sort(candidates.begin(), candidates.end());
  return candidates;
}

bool OccluderTree::Blocked(const Vec3& x, const Vec3& y, uint32_t x_region,
                           uint32_t y_region) const {
  const Vec3 middle = 0.5 * (x + y), half = 0.5 * (y - x), reach = glm::abs(half);
  const double tolerance = set_->tolerance_m();
  bool blocked = false;
  Visit(
      [&](const Bounds3& box) {  // separating axes: the box's own, and those square to the segment
        const Vec3 size = 0.5 * box.Extent() + tolerance;
        const Vec3 d = middle - box.Centre();
        for (int i = 0; i < 3; ++i) {
          if (std::abs(d[i]) > size[i] + reach[i]) return false;
        }
        for (int i = 0; i < 3; ++i) {
          const int j = (i + 1) % 3, k = (i + 2) % 3;
          const double r = size[j] * reach[k] + size[k] * reach[j];
          if (std::abs(d[j] * half[k] - d[k] * half[j]) > r) return false;
        }
        return true;
      },
      [&](uint32_t occluder) {
        const uint32_t region = (*set_)[occluder].region;
        if (region != kNoRegion && (region == x_region || region == y_region)) return true;
        blocked = set_->Blocks(occluder, x, y);
        return !blocked;
      });
  return blocked;
}

}  // namespace isolux
