// Where polygons touch and pass through each other: along these lines light changes abruptly, and
// behind them it must not leak. For the importer, which cuts polygons there.
#pragma once

#include <cstdint>
#include <vector>

#include "client/import/cut.h"
#include "common/scene/box_tree.h"
#include "common/scene/scene.h"

namespace isolux {

class ContactFinder {
 public:
  // Keeps a reference to the scene; takes its polygons as they are now.
  explicit ContactFinder(const Scene& scene);

  // Segments in the plane of a polygon, not clipped to it: edges of others that lie in the plane
  // within the contact tolerance (common/hierarchy/planes.h), whole outlines of coplanar ones among
  // them, and the lines where others pass through it. Panes of glass count among the others.
  std::vector<CutSegment> Of(uint32_t polygon) const;

  double extent_m() const { return extent_; }
  const BoxTree& tree() const { return tree_; }
  const Bounds3& bounds(uint32_t polygon) const { return boxes_[polygon]; }

 private:
  void AddFrom(uint32_t other, const Vec3& point, const Vec3& normal, double size,
               std::vector<CutSegment>* segments) const;

  const Scene& scene_;
  double extent_;
  std::vector<Bounds3> boxes_;
  BoxTree tree_;
};

}  // namespace isolux
