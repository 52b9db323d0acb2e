// Fluorescence.
#include <algorithm>

#include "common/hierarchy/effects/detectors.h"
#include "common/hierarchy/fluorescence.h"

namespace isolux {

// Without it H' = F(E + KH'), with K = ρ + τP; with it H = F(E + KH + MH). So H − H' =
// (I − FK)⁻¹ F MH, and over all channels Σ A(H − H') ≤ m/(1 − α_max) Σ A H, m the largest share of
// what arrives in a channel, or in a spectral band, that is given out in others.
Effect DetectFluorescence(const Hierarchy& hierarchy) {
  double area_m2 = 0, largest = 0;
  for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) {
    const Surface& surface = hierarchy.surfaces()[s];
    const Rgb of_channels = ReradiationOf(hierarchy.scene(), surface).Taken();
    const double taken = std::max({of_channels.y, of_channels.z,
                                   BandReradiationOf(hierarchy.scene(), surface).LargestTaken()});
    if (!(taken > 0)) continue;
    area_m2 += hierarchy.surface_area_m2(s);
    largest = std::max(largest, taken);
  }
  Effect effect{.name = "fluorescence", .present = area_m2 > 0};
  if (!effect.present) {
    effect.evidence = "nothing fluoresces";
    effect.bound = 0.0;
    return effect;
  }
  effect.evidence =
      fmt::format("{:.4g} m² give up to {:.3g} out at longer wavelengths", area_m2, largest);
  effect.bound = largest / (1 - LargestShare(hierarchy, {.reflected = true, .passed = true}));
  return effect;
}

}  // namespace isolux
