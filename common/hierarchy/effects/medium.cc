// A medium that absorbs.
#include "common/hierarchy/effects/detectors.h"
#include "common/hierarchy/effects/landing.h"

namespace isolux {
namespace {

// Power that lands on surfaces with all its bounces, without a medium, is at most P/(1 − α_max), P
// what lamps, lights and sky bring. No way from side to side is longer than the diagonal D of the
// scene, so with τ = 1 − exp(−κ_max D) a medium takes at most τ P/(1 − α_max) of it at once, and
// what that would have brought later no more than 1/(1 − α_max) times as much. Σ A H is no less
// than what lands straight from the lamps through the medium.
std::optional<double> BoundOf(const Hierarchy& hierarchy, double along_diagonal) {
  const double landing_w = LandingPower(hierarchy);
  if (!(landing_w > 0)) return {};
  double power_w = Sum(hierarchy.emitted_w());
  for (const Light& light : hierarchy.scene().lights) {
    power_w += Sum(BroughtPower(hierarchy, light));
  }
  // No sky brings more than four times its mean; see lights.cc.
  power_w += 4 * Sum(SkyPower(hierarchy));
  const double absorbed = 1 - LargestAlbedo(hierarchy);
  return (1 - along_diagonal) * power_w / (absorbed * absorbed) / landing_w;
}

}  // namespace

Effect DetectMedium(const Hierarchy& hierarchy) {
  const Medium& medium = hierarchy.scene().medium;
  Effect effect{.name = "medium", .present = medium.exists()};
  if (!effect.present) {
    effect.evidence = "no medium";
    effect.bound = 0.0;
    return effect;
  }
  const double along_diagonal = ExpOfMinus(medium.largest_per_m() * hierarchy.extent_m());
  const Rgb& extinction = medium.extinction_per_m;
  effect.evidence = fmt::format(
      "extinction {:.4g} {:.4g} {:.4g} per metre; over the scene's diagonal of {:.4g} "
      "m it leaves {:.3g} of the light",
      extinction.x, extinction.y, extinction.z, hierarchy.extent_m(), along_diagonal);
  effect.bound = BoundOf(hierarchy, along_diagonal);
  return effect;
}

}  // namespace isolux
