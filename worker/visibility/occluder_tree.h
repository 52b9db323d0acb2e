// A tree of boxes over occluders, in double: built by Embree's builder, searched by us, since
// Embree itself answers only rays, in single precision. For the candidates of a shaft and for
// segments whose ends touch what they start from.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "worker/visibility/box_shaft.h"
#include "worker/visibility/occluder_set.h"
#include "worker/visibility/shaft.h"

namespace isolux {

class OccluderTree {
 public:
  // Lists of candidates longer than this are not worth going through: the tree is searched anew.
  static constexpr size_t kLongList = 32;

  // Keeps a pointer to the set, which must not change any more.
  explicit OccluderTree(const OccluderSet& set);

  const OccluderSet& set() const { return *set_; }

  // What the shaft meets. Those that may block part of it are left in `candidates`, in order of
  // their numbers, where the verdict is kPartial. `parent`: the candidates of a shaft that holds
  // this one.
  Verdict Settle(const Shaft& shaft, std::span<const uint32_t> parent,
                 std::vector<uint32_t>* candidates) const;
  Verdict Settle(const Shaft& shaft, std::vector<uint32_t>* candidates) const;

  // The same, but gives up where more than `most` may block part of it: kPartial, and more than
  // `most` candidates, in no order.
  Verdict SettleShort(const Shaft& shaft, size_t most, std::vector<uint32_t>* candidates) const;

  // All that may block anything between two boxes, in order.
  std::vector<uint32_t> Candidates(const BoxShaft& shaft) const;

  // Whether anything crosses the open segment from x to y, but for occluders of the regions that x
  // and y lie in. What lies in the plane of an end point does not.
  bool Blocked(const Vec3& x, const Vec3& y, uint32_t x_region = kNoRegion,
               uint32_t y_region = kNoRegion) const;

 private:
  struct Node {
    Bounds3 bounds;
    uint32_t first = 0;  // child node; of a leaf the first of order_
    uint32_t count = 0;  // of occluders in a leaf; 0: an inner node with children first, first + 1
  };
  // Calls leaf(occluder) for those in boxes that `touches`; stops where it returns false.
  template <typename Touches, typename Leaf>
  void Visit(const Touches& touches, const Leaf& leaf) const;

  const OccluderSet* set_;
  std::vector<Node> nodes_;
  std::vector<uint32_t> order_;
};

}  // namespace isolux
