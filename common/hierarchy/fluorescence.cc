#include "common/hierarchy/fluorescence.h"

#include <algorithm>

namespace isolux {
namespace {

// The side's material, or null where it does not take part.
const Material* MaterialOf(const Scene& scene, const Surface& surface) {
  const Polygon& polygon = scene.polygons[surface.polygon];
  const uint8_t takes_part = surface.side == Side::kFront ? kFrontTakesPart : kBackTakesPart;
  return (polygon.sides & takes_part) != 0 ? &scene.materials[polygon.material] : nullptr;
}

}  // namespace

Reradiation ReradiationOf(const Scene& scene, const Surface& surface) {
  const Material* material = MaterialOf(scene, surface);
  return material != nullptr ? material->reradiation : Reradiation();
}

const BandReradiation& BandReradiationOf(const Scene& scene, const Surface& surface) {
  static const BandReradiation kNone;
  const Material* material = MaterialOf(scene, surface);
  return material != nullptr ? material->spectrum.reradiation : kNone;
}

Fluorescence::Fluorescence(const Hierarchy& hierarchy, const EffectsPlan& plan) {
  if (!plan.fluorescence) return;
  for (const Surface& surface : hierarchy.surfaces()) {
    of_surface_.push_back(ReradiationOf(hierarchy.scene(), surface));
  }
  if (std::ranges::none_of(of_surface_, &Reradiation::exists)) of_surface_.clear();
}

}  // namespace isolux
