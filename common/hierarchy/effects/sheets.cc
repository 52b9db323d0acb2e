// Translucent sheets.
#include <algorithm>

#include "common/hierarchy/effects/detectors.h"
#include "common/hierarchy/effects/landing.h"
#include "common/hierarchy/fluorescence.h"
#include "common/scene/translucency.h"

namespace isolux {
namespace {

double LargestOf(const Rgb& c) { return std::max({c.x, c.y, c.z}); }

// With sheets H = F(E + ρH + τPH), P from side to side; without H' = F(E + ρH'). So H − H' =
// (I − Fρ)⁻¹ F τPH, and Σ A(H − H') ≤ Σ τ A H/(1 − ρ_max), ρ with what is reradiated. What sheets
// pass on is at most τ of all light, and no more than what falls on their area times τ, since a
// sheet brightens nothing.
double BoundOf(const Hierarchy& hierarchy, double largest, double passing_m2) {
  const double rest = 1 - LargestShare(hierarchy, {.reflected = true, .reradiated = true});
  return std::min(largest, LargestShareOfLight(hierarchy, passing_m2)) / rest;
}

// Of the bands in which a spectrum tells what the surface does; 0: none does.
double LargestInBands(const Hierarchy& hierarchy, const Surface& surface, const Shares& shares) {
  const Scene& scene = hierarchy.scene();
  const Spectrum& spectrum = scene.materials[scene.polygons[surface.polygon].material].spectrum;
  if (!spectrum.exists()) return 0;
  const bool reflects = surface.reflectance != Rgb(0.0);
  const Rgb passed = TransmittanceOf(hierarchy, surface);
  const double brightest =
      hierarchy.maps().Varies(surface.polygon) ? hierarchy.maps().Largest(surface) : 0.0;
  double largest = 0;
  for (size_t b = 0; b < scene.bands.size(); ++b) {
    const int c = scene.bands[b].channel();
    double share = 0;
    if (shares.reflected && reflects) {
      share = spectrum.reflectance.empty() ? std::max(brightest, surface.reflectance[c])
                                           : spectrum.reflectance[b];
    }
    if (shares.passed && passed != Rgb(0.0)) {
      share += spectrum.transmittance.empty() ? passed[c] : spectrum.transmittance[b];
    }
    if (shares.reradiated) share += BandReradiationOf(scene, surface).Taken(b);
    largest = std::max(largest, share);
  }
  return largest;
}

}  // namespace

Rgb TransmittanceOf(const Hierarchy& hierarchy, const Surface& surface) {
  const Scene& scene = hierarchy.scene();
  const Polygon& polygon = scene.polygons[surface.polygon];
  return IsSheet(scene, polygon) ? scene.materials[polygon.material].transmittance : Rgb(0.0);
}

double LargestShare(const Hierarchy& hierarchy, const Shares& shares) {
  double largest = 0;
  for (const Surface& surface : hierarchy.surfaces()) {
    largest = std::max(largest, LargestInBands(hierarchy, surface, shares));
    Rgb other(0.0);
    if (shares.passed) other += TransmittanceOf(hierarchy, surface);
    if (shares.reradiated) other += ReradiationOf(hierarchy.scene(), surface).Taken();
    if (!shares.reflected) {
      largest = std::max(largest, LargestOf(other));
    } else if (hierarchy.maps().Varies(surface.polygon)) {
      // Of a map the brightest texel, in whatever channel.
      largest = std::max(largest, hierarchy.maps().Largest(surface) + LargestOf(other));
    } else {
      largest = std::max(largest, LargestOf(surface.reflectance + other));
    }
  }
  return largest;
}

double LargestAlbedo(const Hierarchy& hierarchy) {
  return LargestShare(hierarchy, {.reflected = true, .passed = true, .reradiated = true});
}

Effect DetectSheets(const Hierarchy& hierarchy) {
  double sides_m2 = 0, passing_m2 = 0, largest = 0;
  uint64_t sides = 0;
  for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) {
    const Rgb passed = TransmittanceOf(hierarchy, hierarchy.surfaces()[s]);
    if (passed == Rgb(0.0)) continue;
    ++sides;
    sides_m2 += hierarchy.surface_area_m2(s);
    passing_m2 += hierarchy.surface_area_m2(s) * LargestOf(passed);
    largest = std::max(largest, LargestOf(passed));
  }
  Effect effect{.name = "sheets", .present = sides > 0};
  if (sides == 0) {
    effect.evidence = "no translucent sheet";
    effect.bound = 0.0;
    return effect;
  }
  effect.evidence = fmt::format("{:.4g} m² in {} polygon{} pass on up to {:.3g}", sides_m2 / 2,
                                sides / 2, sides == 2 ? "" : "s", largest);
  effect.bound = BoundOf(hierarchy, largest, passing_m2);
  return effect;
}

}  // namespace isolux
