#include <algorithm>
#include <cmath>

#include "common/hierarchy/effects/detectors.h"
#include "common/hierarchy/fluorescence.h"

namespace isolux {
namespace {

double LargestOf(const Rgb& c) { return std::max({c.x, c.y, c.z}); }

std::string Counted(size_t count, const char* what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

// Largest distance of a channel's reflectance from the mean of the surface's, with the largest such
// mean; what sheets pass on is added to both.
struct Tint {
  double largest = 0, mean = 0;
  double area_m2 = 0, total_m2 = 0;  // of surfaces that are not grey, of all
};

Tint FindTint(const Hierarchy& hierarchy) {
  Tint tint;
  for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) {
    const Surface& surface = hierarchy.surfaces()[s];
    const Rgb& rho = surface.reflectance;
    double mean = GreyOf(rho), off = LargestOf(glm::abs(rho - Rgb(mean)));
    if (hierarchy.maps().Varies(surface.polygon)) {
      // A texel may be that much brighter than the mean; of a coloured one no channel is off by
      // more than the brightest.
      const double brightest = hierarchy.maps().Largest(surface);
      const bool tints = hierarchy.maps().TintsReflectance(surface);
      off = tints ? brightest : mean > 0 ? off * std::max(1.0, brightest / mean) : off;
      mean = std::max(mean, brightest);
    }
    const Rgb passed = TransmittanceOf(hierarchy, surface);
    if (passed != Rgb(0.0)) {
      off += LargestOf(glm::abs(passed - Rgb(GreyOf(passed))));
      mean += GreyOf(passed);
    }
    tint.largest = std::max(tint.largest, off);
    tint.mean = std::max(tint.mean, mean);
    tint.total_m2 += hierarchy.surface_area_m2(s);
    if (off > 1e-9) tint.area_m2 += hierarchy.surface_area_m2(s);
  }
  return tint;
}

// What shines, W/m² or W/sr, lamps first.
std::vector<Rgb> ColoursOfLight(const Hierarchy& hierarchy) {
  std::vector<Rgb> colours;
  for (const Surface& s : hierarchy.surfaces()) colours.push_back(s.exitance);
  for (const Light& light : hierarchy.scene().lights) colours.push_back(light.intensity);
  const auto& sky = hierarchy.scene().sky.texels;
  for (size_t i = 0; i < sky.size(); i += 3) colours.push_back({sky[i], sky[i + 1], sky[i + 2]});
  std::erase_if(colours, [](const Rgb& colour) { return !(Sum(colour) > 0); });
  return colours;
}

// Whether all lamps are of one colour, bright or dim.
bool LampsAreAlike(const Hierarchy& hierarchy) {
  for (const Surface& s : hierarchy.surfaces()) {
    if (Sum(s.exitance) > 0 && hierarchy.maps().TintsExitance(s)) return false;
  }
  const std::vector<Rgb> colours = ColoursOfLight(hierarchy);
  return std::ranges::all_of(colours, [&](const Rgb& colour) {
    const Rgb off = colour / Sum(colour) - colours[0] / Sum(colours[0]);
    return LargestOf(glm::abs(off)) <= 1e-9;
  });
}

}  // namespace

// With ρ' = ρ + δ in place of ρ, H' − H = (I − Fρ')⁻¹ F (ρ' − ρ) H, and F hands on no more power
// than it takes: Σ A|H' − H| ≤ δ/(1 − ρ'max) Σ A H, channel by channel. Lamps of several colours
// and media or panes that absorb in colour have no such bound, nor has fluorescence.
Effect DetectChannels(const Hierarchy& hierarchy) {
  const Tint tint = FindTint(hierarchy);
  const bool in_medium = !hierarchy.scene().medium.is_grey();
  const bool in_glass = !hierarchy.scene().glazing.is_grey();
  const bool fluorescent = std::ranges::any_of(hierarchy.surfaces(), [&](const Surface& s) {
    return ReradiationOf(hierarchy.scene(), s).exists();
  });
  const bool tinted = in_medium || in_glass || fluorescent;
  const bool alike = LampsAreAlike(hierarchy) && !tinted;
  Effect effect{.name = "colour", .present = tint.largest > 1e-9 || !alike};
  effect.evidence = fmt::format(
      "{:.4g} of {:.4g} m² reflect in colour, up to {:.3g} off grey; lamps of {}", tint.area_m2,
      tint.total_m2, tint.largest, LampsAreAlike(hierarchy) ? "one colour" : "several");
  if (in_medium) effect.evidence += "; a medium in colour";
  if (in_glass) effect.evidence += "; glass in colour";
  if (fluorescent) effect.evidence += "; fluorescence";
  if (alike) effect.bound = tint.largest > 1e-9 ? tint.largest / (1 - tint.mean) : 0.0;
  return effect;
}

// What bands find the channels do not bound.
Effect DetectColour(const Hierarchy& hierarchy) {
  Effect effect = DetectChannels(hierarchy);
  const size_t bands = hierarchy.scene().bands.size();
  if (bands == 0) return effect;
  effect.present = true;
  effect.bound.reset();
  effect.evidence += fmt::format("; {} in {}", Counted(bands, "spectral band"),
                                 Counted(BandGroupCount(bands), "group"));
  return effect;
}

// Where the lamps are alike, the number is what they emit in the strongest channel, to the bit.
// Otherwise it keeps their power.
void SetLightColour(const Hierarchy& hierarchy, EffectsPlan* plan) {
  Rgb emitted_w(0.0), brightest(0.0);
  for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) {
    emitted_w += hierarchy.surface_area_m2(s) * hierarchy.surfaces()[s].exitance;
  }
  for (const Light& light : hierarchy.scene().lights) emitted_w += BroughtPower(hierarchy, light);
  if (hierarchy.scene().sky.exists()) emitted_w += SkyPower(hierarchy);
  for (const Rgb& colour : ColoursOfLight(hierarchy)) {
    if (Sum(colour) > Sum(brightest)) brightest = colour;
  }
  if (!(Sum(brightest) > 0)) return;
  const bool alike = LampsAreAlike(hierarchy);
  const Rgb& light = alike ? brightest : emitted_w;
  plan->light_colour = light / LargestOf(light);
  plan->exitance_weights = Rgb(1 / Sum(plan->light_colour));
  if (!alike) return;
  int strongest = 0;
  while (light[strongest] < LargestOf(light)) ++strongest;
  plan->exitance_weights = Rgb(0.0);
  plan->exitance_weights[strongest] = 1;
}

}  // namespace isolux
