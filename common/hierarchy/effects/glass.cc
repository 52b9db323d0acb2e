// Panes of clear glass.
#include <algorithm>
#include <optional>

#include "common/hierarchy/effects/detectors.h"
#include "common/hierarchy/effects/landing.h"
#include "common/scene/glazing.h"

namespace isolux {
namespace {

double LargestOf(const Rgb& c) { return std::max({c.x, c.y, c.z}); }

// Of light that comes to panes alike from everywhere, sums over both sides of their areas, m².
struct Sums {
  double area_m2 = 0;
  double taken_m2 = 0, reflected_m2 = 0;  // in the channel in which they take or reflect most
  double least = 1, most = 0;             // left at normal incidence
};

Sums SumsOver(const Glazing& glazing) {
  std::vector<Rgb> left, reflected;
  for (const Glass& glass : glazing.glasses) {
    left.push_back(glass.MeanTransmittance());
    reflected.push_back(glass.MeanReflectance());
  }
  Sums sums;
  for (const Pane& pane : glazing.panes) {
    ConvexPolygon shape;
    shape.count = static_cast<int>(pane.count);
    shape.v = pane.corners;
    const double area_m2 = shape.Area();
    sums.area_m2 += area_m2;
    sums.taken_m2 += 2 * area_m2 * LargestOf(Rgb(1.0) - left[pane.glass]);
    sums.reflected_m2 += 2 * area_m2 * LargestOf(reflected[pane.glass]);
    const Rgb straight = glazing.glasses[pane.glass].Transmittance(1);
    sums.least = std::min({sums.least, straight.x, straight.y, straight.z});
    sums.most = std::max(sums.most, LargestOf(straight));
  }
  return sums;
}

// Without panes H' = F(E + ρH'), with them H = TF(E + ρH): H' − H = Fρ(H' − H) + (F − TF)(E + ρH),
// so Σ A(H' − H) is at most P/(1 − α_max), P what the panes take. No light of lamps alone is
// brighter than E_max/(1 − α_max), so from either side a pane takes at most that times its area
// times what it takes of even light; and Σ A H is no less than what lands straight from the lamps
// through the panes. Power that a pane reflects, brought back, counts likewise. Light of points,
// suns and skies may be any times brighter; and mirrors and maps are not in these sums.
std::optional<double> BoundOf(const Hierarchy& hierarchy, double weight_m2) {
  const Scene& scene = hierarchy.scene();
  const bool from_maps = std::ranges::any_of(
      scene.materials, [](const Material& m) { return m.exitance_map.texture != kNoTexture; });
  if (!scene.lights.empty() || scene.sky.exists() || from_maps) return {};
  const double landing_w = LandingPower(hierarchy);
  if (!(landing_w > 0)) return {};
  Rgb brightest(0.0);
  for (const Surface& surface : hierarchy.surfaces()) {
    brightest = glm::max(brightest, surface.exitance);
  }
  const double rest = 1 - LargestAlbedo(hierarchy);
  return weight_m2 * Sum(brightest) / (rest * rest) / landing_w;
}

}  // namespace

Effect DetectClearGlass(const Hierarchy& hierarchy) {
  const Glazing& glazing = hierarchy.scene().glazing;
  Effect replaced = DetectReplacedGlass(hierarchy.scene());
  if (!glazing.exists()) {
    if (!replaced.present) replaced.support = Support::kSwitchable;
    return replaced;
  }
  const Sums sums = SumsOver(glazing);
  Effect effect{.name = "clear-glass", .present = true};
  effect.evidence =
      fmt::format("{} pane{} of {:.4g} m² that leave {:.3g} to {:.3g} of light that falls straight",
                  glazing.panes.size(), glazing.panes.size() == 1 ? "" : "s", sums.area_m2,
                  sums.least, sums.most);
  effect.bound = BoundOf(hierarchy, sums.taken_m2);
  if (sums.reflected_m2 > 0) {
    const std::optional<double> reflected = BoundOf(hierarchy, sums.reflected_m2);
    effect.evidence += "; what they reflect counts as absorbed: ";
    effect.evidence += reflected.value_or(1) < 1
                           ? fmt::format("{:.2g} of all light at most", *reflected)
                           : fmt::format("{:.2g} of what falls on them from all round",
                                         0.5 * sums.reflected_m2 / sums.area_m2);
  }
  if (replaced.present) effect.evidence += "; taken as opaque: " + replaced.evidence;
  return effect;
}

}  // namespace isolux
