#include "common/hierarchy/fluorescence.h"

#include <algorithm>

namespace isolux {

Reradiation ReradiationOf(const Scene& scene, const Surface& surface) {
  const Polygon& polygon = scene.polygons[surface.polygon];
  const uint8_t takes_part = surface.side == Side::kFront ? kFrontTakesPart : kBackTakesPart;
  return (polygon.sides & takes_part) != 0 ? scene.materials[polygon.material].reradiation
                                           : Reradiation();
}

Fluorescence::Fluorescence(const Hierarchy& hierarchy, const EffectsPlan& plan) {
  if (!plan.fluorescence) return;
  for (const Surface& surface : hierarchy.surfaces()) {
    of_surface_.push_back(ReradiationOf(hierarchy.scene(), surface));
  }
  if (std::ranges::none_of(of_surface_, &Reradiation::exists)) of_surface_.clear();
}

}  // namespace isolux
