// Lobes between diffuse and mirror, which are not simulated.
#include <algorithm>

#include "common/hierarchy/effects/detectors.h"
#include "common/hierarchy/effects/landing.h"
#include "common/hierarchy/fluorescence.h"

namespace isolux {
namespace {

double LargestOf(const Rgb& c) { return std::max({c.x, c.y, c.z}); }

const Material& MaterialOf(const Scene& scene, const Surface& surface) {
  return scene.materials[scene.polygons[surface.polygon].material];
}

// With H what arrives in truth, of which lobes hand on S, and H' what is solved for, in which D is
// handed on diffusely for them: H − H' = (I − FK)⁻¹ (S − D), K what the other ways hand on, mirrors
// included, and Σ A |S − D| ≤ Σ w A H, with w the share of the lobes, twice where the reflectance
// holds it. So Σ A |H − H'| ≤ Σ w A H/(1 − α_max): w of all light at most; and no more than w times
// their area times the brightest that shines on them, which a lobe does not add to either.
class Bound {
 public:
  explicit Bound(const Hierarchy& hierarchy) : hierarchy_(hierarchy) {}

  void Add(uint32_t s, const Gloss& gloss) {
    const double weight = (gloss.kept ? 2 : 1) * LargestOf(gloss.share);
    const bool varies = gloss.kept && hierarchy_.maps().Varies(hierarchy_.surfaces()[s].polygon);
    largest_ = std::max(largest_,
                        varies ? 2 * hierarchy_.maps().Largest(hierarchy_.surfaces()[s]) : weight);
    weighted_m2_ += hierarchy_.surface_area_m2(s) * weight;
    // A lamp that shines on itself by way of it may be brighter.
    shining_ |= hierarchy_.surfaces()[s].exitance != Rgb(0.0);
  }

  std::optional<double> Value() const {
    const double rest = 1 - std::max(LargestAlbedo(hierarchy_), LargestOfMirrors());
    if (!(rest > 0)) return {};
    const double of_light = shining_ ? largest_ : LargestShareOfLight(hierarchy_, weighted_m2_);
    return std::min(largest_, of_light) / rest;
  }

 private:
  // What mirrors hand on, diffusely beside.
  double LargestOfMirrors() const {
    double largest = 0;
    for (const Surface& surface : hierarchy_.surfaces()) {
      const double specular = MaterialOf(hierarchy_.scene(), surface).specular;
      if (!(specular > 0)) continue;
      const double diffuse = hierarchy_.maps().Varies(surface.polygon)
                                 ? hierarchy_.maps().Largest(surface)
                                 : LargestOf(surface.reflectance);
      largest =
          std::max(largest, specular + diffuse + LargestOf(TransmittanceOf(hierarchy_, surface)) +
                                LargestOf(ReradiationOf(hierarchy_.scene(), surface).Taken()));
    }
    return largest;
  }

  const Hierarchy& hierarchy_;
  double largest_ = 0, weighted_m2_ = 0;
  bool shining_ = false;
};

}  // namespace

Effect DetectGloss(const Hierarchy& hierarchy) {
  Effect effect{.name = "gloss"};
  effect.support = Support::kNotSimulated;
  Bound bound(hierarchy);
  double area_m2 = 0, largest = 0;
  bool kept = false, absorbed = false;
  for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) {
    const Gloss& gloss = MaterialOf(hierarchy.scene(), hierarchy.surfaces()[s]).gloss;
    if (!gloss.exists()) continue;
    bound.Add(s, gloss);
    area_m2 += hierarchy.surface_area_m2(s);
    largest = std::max(largest, LargestOf(gloss.share));
    (gloss.kept ? kept : absorbed) = true;
  }
  effect.present = area_m2 > 0;
  if (!effect.present) {
    effect.evidence = "no lobe between diffuse and mirror";
    effect.bound = 0.0;
    return effect;
  }
  effect.evidence = fmt::format("{:.4g} of {:.4g} m² reflect up to {:.3g} in lobes", area_m2,
                                hierarchy.clusters()[0].area_m2, largest);
  effect.bound = bound.Value();
  effect.reason = kept && absorbed ? "taken as diffuse: of metals with the lobe, else without"
                  : kept           ? "taken as diffuse, with the lobe"
                                   : "taken as diffuse, with Kd";
  return effect;
}

}  // namespace isolux
