// Light that comes from no polygon: points, spots, directional lights.
#include <algorithm>

#include "common/hierarchy/effects/detectors.h"

namespace isolux {

// What a light brings without obstacles: of points and spots no more than all of their power, of
// directional lights what falls on sides that face them.
Rgb BroughtPower(const Hierarchy& hierarchy, const Light& light) {
  if (light.kind != LightKind::kDirectional) return PowerOf(light);
  double across_m2 = 0;
  for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) {
    const double cosine = -glm::dot(hierarchy.geometry(s).Normal(), light.direction);
    across_m2 += hierarchy.surface_area_m2(s) * std::max(0.0, cosine);
  }
  return across_m2 * light.intensity;
}

bool ShinesFromOutside(const Hierarchy& hierarchy, const Light& light) {
  if (light.kind == LightKind::kDirectional) return true;
  for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) {
    const ConvexPolygon& polygon = hierarchy.geometry(s);
    if (glm::dot(polygon.Normal(), light.position_m - polygon.v[0]) < 0) return true;
  }
  return false;
}

Effect DetectLights(const Hierarchy& hierarchy) {
  const auto& lights = hierarchy.scene().lights;
  Effect effect{.name = "lights", .present = !lights.empty()};
  if (lights.empty()) {
    effect.evidence = "no light without area";
    effect.bound = 0.0;
    return effect;
  }
  Rgb power(0.0);
  for (const Light& light : lights) power += BroughtPower(hierarchy, light);
  const auto count = [&](LightKind kind) { return std::ranges::count(lights, kind, &Light::kind); };
  effect.evidence = fmt::format("points: {}, spots: {}, directions: {}; {:.4g} W at most",
                                count(LightKind::kPoint), count(LightKind::kSpot),
                                count(LightKind::kDirectional), Sum(power));
  return effect;
}

}  // namespace isolux
