#include <algorithm>

#include "common/hierarchy/effects/detectors.h"

namespace isolux {

Effect DetectOcclusion(const Hierarchy& hierarchy) {
  const auto& lights = hierarchy.scene().lights;
  const bool from_outside =
      hierarchy.scene().sky.exists() || std::ranges::any_of(lights, [&](const Light& light) {
        return ShinesFromOutside(hierarchy, light);
      });
  Effect effect{.name = "occlusion", .present = !hierarchy.convex() || from_outside};
  if (!hierarchy.convex()) {
    effect.evidence = "polygons stand in front of others";
  } else if (from_outside) {
    effect.evidence = "one convex room, with light from outside";
  } else {
    effect.evidence = "one convex room: nothing stands between";
    effect.bound = 0.0;
  }
  return effect;
}

// Without it H = FE alone. What is missing is F(ρH), and F hands on no more power than it takes:
// Σ A(H − FE) ≤ Σ A ρH ≤ ρ_max Σ A H. What sheets pass on of that, and what is reradiated of it, is
// missing too: all of it is at most 1/(1 − τ_max) times as much, τ both.
Effect DetectInterreflection(const Hierarchy& hierarchy) {
  const double rho = LargestShare(hierarchy, {.reflected = true});
  Effect effect{.name = "interreflection", .present = rho > 0};
  double area = 0, emitted = 0;
  for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) {
    const Surface& surface = hierarchy.surfaces()[s];
    if (Sum(surface.reflectance) > 0) area += hierarchy.surface_area_m2(s);
    emitted += hierarchy.surface_area_m2(s) * Sum(surface.exitance);
  }
  effect.evidence = fmt::format("{:.4g} of {:.4g} m² reflect, up to {:.3g}", area,
                                hierarchy.clusters()[0].area_m2, rho);
  // Light of the sky, the sun and points arrives without a surface that emits it.
  if (emitted > 0) effect.evidence += fmt::format(", of {:.4g} W that surfaces emit", emitted);
  effect.bound = rho / (1 - LargestShare(hierarchy, {.passed = true, .reradiated = true}));
  return effect;
}

// What couplings miss of a row is magnified by 1/(1 − ρ); without reflection by nothing. How much
// they miss the scene alone does not tell.
Effect DetectClosure(const Hierarchy& hierarchy) {
  const double rho = LargestAlbedo(hierarchy);
  Effect effect{.name = "closure", .present = rho > 0};
  effect.evidence = fmt::format("errors of couplings count up to {:.3g} times", 1 / (1 - rho));
  return effect;
}

Effect DetectTwoSided(const Hierarchy& hierarchy) {
  const auto& polygons = hierarchy.scene().polygons;
  std::vector<uint8_t> sides(polygons.size(), 0);
  double area = 0, area_of_both = 0;
  uint64_t both = 0;
  for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) {
    const uint32_t polygon = hierarchy.surfaces()[s].polygon;
    area += hierarchy.surface_area_m2(s);
    if (++sides[polygon] < 2) continue;
    ++both;
    area_of_both += 2 * hierarchy.surface_area_m2(s);
  }
  Effect effect{.name = "two-sided", .present = both > 0};
  effect.support = Support::kFixed;
  effect.evidence = fmt::format("{} of {} polygons take part with both sides, {:.4g} of {:.4g} m²",
                                both, polygons.size(), area_of_both, area);
  if (!effect.present) effect.bound = 0.0;
  effect.reason = both > 0 ? "a surface for each side, as --reflect and --emit ask"
                           : "one surface for each polygon";
  return effect;
}

}  // namespace isolux
