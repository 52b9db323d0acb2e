// What surfaces reradiate: with M their material's matrix from channels of shorter wavelength to
// longer ones, B = E + ρH + MH. To all that works with B = E + ρH what is reradiated is exitance.
#pragma once

#include <vector>

#include "common/hierarchy/hierarchy.h"
#include "common/scene/effects_plan.h"

namespace isolux {

class Fluorescence {
 public:
  Fluorescence() = default;  // none
  // That of the scene, where the plan wants it.
  Fluorescence(const Hierarchy& hierarchy, const EffectsPlan& plan);

  bool empty() const { return of_surface_.empty(); }
  const Reradiation& Of(uint32_t surface) const {
    static constexpr Reradiation kNone;
    return empty() ? kNone : of_surface_[surface];
  }

 private:
  std::vector<Reradiation> of_surface_;
};

// Of a side: none where it does not take part.
Reradiation ReradiationOf(const Scene& scene, const Surface& surface);
// The same between spectral bands, of a scene that has them.
const BandReradiation& BandReradiationOf(const Scene& scene, const Surface& surface);

}  // namespace isolux
