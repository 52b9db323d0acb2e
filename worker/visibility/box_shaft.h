// The hull of two boxes, a little enlarged: which occluders may stand between anything in one box
// and anything in the other ([HainesWallace91]). A first cut for many pairs at once; Shaft decides
// for each.
#pragma once

#include <array>

#include "worker/visibility/occluder_set.h"
#include "worker/visibility/shaft.h"

namespace isolux {

class BoxShaft {
 public:
  BoxShaft(const Bounds3& a, const Bounds3& b);

  bool MayTouch(const Bounds3& box) const;
  // False only where the occluder crosses no segment between the boxes.
  bool MayBlock(const OccluderSet& set, const Occluder& occluder) const;

 private:
  Bounds3 a_, b_, both_;
  std::array<HalfSpace, 12> planes_;
  int plane_count_ = 0;
};

}  // namespace isolux
