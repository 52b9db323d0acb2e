// Reflectance maps.
#include <algorithm>

#include "common/hierarchy/effects/detectors.h"
#include "common/hierarchy/effects/landing.h"

namespace isolux {

// With δ what the map is off from its mean over a surface, H' − H = (I − FK')⁻¹ F δH, so that
// Σ ∫|H' − H| dA ≤ Σ ∫|δ|H dA/(1 − α_max). That is at most the largest |δ| of all light; and, as
// the mean of |δ| is no more than its deviation σ, no more than what falls on an area of Σ σA.
double BoundOfTextures(const Hierarchy& hierarchy) {
  double largest = 0, varying_m2 = 0;
  for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) {
    const Surface& surface = hierarchy.surfaces()[s];
    if (!hierarchy.maps().VariesReflectance(surface.polygon)) continue;
    const Rgb& mean = surface.reflectance;
    const double least = std::min({mean.x, mean.y, mean.z});
    const double most = std::max({mean.x, mean.y, mean.z});
    largest = std::max({largest, hierarchy.maps().Largest(surface) - least, most});
    const Rgb deviation =
        hierarchy.maps().Over(surface, hierarchy.geometry(s)).reflectance_deviation;
    varying_m2 += hierarchy.surface_area_m2(s) * std::max({deviation.x, deviation.y, deviation.z});
  }
  if (!(varying_m2 > 0)) return 0;
  return std::min(largest, LargestShareOfLight(hierarchy, varying_m2)) /
         (1 - LargestAlbedo(hierarchy));
}

}  // namespace isolux
