#include "common/hierarchy/mirrors.h"

#include <algorithm>

#include "common/hierarchy/effects/detectors.h"
#include "common/hierarchy/effects/landing.h"

namespace isolux {
namespace {

// Without mirrors H' = F(E + ρH'), with them H = F(E + ρH) + S, and S brings what they reflect:
// Σ A S = P = Σ k_s A H over the mirrors. So Σ A(H − H') ≤ P/(1 − ρ_max). P is at most k_s of all
// light; and no more than k_s times their area times the brightest that shines on them,
// E_max/(1 − ρ_max), since a mirror brightens nothing; and Σ A H is no less than what lands
// straight from the lamps.
double BoundOf(const Hierarchy& hierarchy, std::span<const MirrorPlane> planes) {
  const double rest = 1 - LargestReflectance(hierarchy);
  double largest = 0, reflecting_m2 = 0;
  for (const MirrorPlane& plane : planes) {
    largest = std::max(largest, plane.share);
    reflecting_m2 += plane.share * plane.area_m2;
  }
  const double landing_w = LandingPower(hierarchy);
  const Scene& scene = hierarchy.scene();
  const bool from_maps = std::ranges::any_of(
      scene.materials, [](const Material& m) { return m.exitance_map.texture != kNoTexture; });
  if (!(landing_w > 0) || !scene.lights.empty() || scene.sky.exists() || from_maps) {
    return largest / rest;
  }
  Rgb brightest(0.0);
  for (const Surface& surface : hierarchy.surfaces()) {
    brightest = glm::max(brightest, surface.exitance);
  }
  const double share = reflecting_m2 * Sum(brightest) / rest / landing_w;
  return std::min(largest, share) / rest;
}

// Images for which there is no room.
std::string WhatIsLeftOut(const Hierarchy& hierarchy, double accuracy) {
  const double missing = Mirrors(hierarchy, accuracy).missing();
  if (!(missing > 0)) return {};
  return fmt::format(
      "; images beyond the first {} are left out, each up to {:.2g} of what falls on"
      " its mirrors",
      Mirrors::kMostImages, missing);
}

}  // namespace

Effect DetectMirrors(const Hierarchy& hierarchy, double accuracy) {
  const std::vector<MirrorPlane> planes = MirrorPlanesOf(hierarchy);
  Effect replaced = DetectReplacedMirrors(hierarchy.scene());
  if (planes.empty()) {
    if (replaced.present) return replaced;
    replaced.support = Support::kSwitchable;
    return replaced;
  }
  Effect effect{.name = "mirrors", .present = true};
  double area_m2 = 0, largest = 0;
  for (const MirrorPlane& plane : planes) {
    area_m2 += plane.area_m2;
    largest = std::max(largest, plane.share);
  }
  effect.evidence = fmt::format("{:.4g} m² in {} plane{} reflect up to {:.3g} as mirrors", area_m2,
                                planes.size(), planes.size() == 1 ? "" : "s", largest);
  effect.bound = BoundOf(hierarchy, planes);
  if (planes.size() > Mirrors::kMostPlanes) {
    effect.support = Support::kNotSimulated;
    effect.reason =
        fmt::format("more than {} planes: taken as diffuse, with Kd", Mirrors::kMostPlanes);
  } else {
    effect.evidence += WhatIsLeftOut(hierarchy, accuracy);
  }
  return effect;
}

}  // namespace isolux
