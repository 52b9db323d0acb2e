#include "client/commands/effects.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "client/import/repair.h"

namespace isolux {
namespace {

double LargestOf(const Rgb& c) { return std::max({c.x, c.y, c.z}); }

double LargestReflectance(const Hierarchy& hierarchy) {
  double largest = 0;
  for (const Surface& s : hierarchy.surfaces())
    largest = std::max(largest, LargestOf(s.reflectance));
  return largest;
}

// Reflectance of any channel away from the mean of its surface's, δ; then B changes by at most
// δ/(1 − ρ_max) when one channel stands for all.
double LargestTint(const Hierarchy& hierarchy) {
  double tint = 0;
  for (const Surface& s : hierarchy.surfaces()) {
    const Rgb difference = s.reflectance - Rgb(Sum(s.reflectance) / 3);
    tint = std::max({tint, std::abs(difference.x), std::abs(difference.y), std::abs(difference.z)});
  }
  return tint;
}

// Whether all lamps are of one colour, bright or dim.
bool LampsAreAlike(const Hierarchy& hierarchy) {
  Rgb first(0.0);
  for (const Surface& s : hierarchy.surfaces()) {
    const double sum = Sum(s.exitance);
    if (!(sum > 0)) continue;
    const Rgb colour = s.exitance / sum;
    if (Sum(first) == 0) first = colour;
    if (LargestOf(glm::abs(colour - first)) > 1e-9) return false;
  }
  return true;
}

Effect ColourChannels(const Hierarchy& hierarchy) {
  const double tint = LargestTint(hierarchy);
  const bool alike = LampsAreAlike(hierarchy);
  Effect effect{"colour channels", tint > 1e-9 || !alike, {}, {}, "three channels"};
  effect.evidence = fmt::format("reflectances up to {:.3g} off grey, lamps of {}", tint,
                                alike ? "one colour" : "several colours");
  if (alike) effect.bound = tint / (1 - LargestReflectance(hierarchy));
  return effect;
}

Effect Occlusion(const Hierarchy& hierarchy) {
  if (hierarchy.convex()) {
    return {"occlusion", false, "one convex room: nothing stands between", 0.0, "no rays"};
  }
  return {"occlusion", true, "polygons stand in front of others", {}, "shadow rays"};
}

Effect Interreflection(const Hierarchy& hierarchy) {
  const double rho = LargestReflectance(hierarchy);
  return {"interreflection", rho > 0, fmt::format("reflectance up to {:.3g}", rho), rho / (1 - rho),
          rho > 0 ? "solved for" : "nothing to solve for"};
}

Effect TwoSided(const Hierarchy& hierarchy) {
  const auto& polygons = hierarchy.scene().polygons;
  const auto both = std::count_if(polygons.begin(), polygons.end(), [](const Polygon& p) {
    return (p.sides & (kFrontTakesPart | kFrontEmits)) != 0 &&
           (p.sides & (kBackTakesPart | kBackEmits)) != 0;
  });
  return {"two-sided polygons", both > 0,
          fmt::format("{} of {} polygons take part with both sides", both, polygons.size()),
          both > 0 ? std::nullopt : std::optional<double>(0.0),
          both > 0 ? "a surface for each side" : "one surface for each polygon"};
}

// An effect that the importer found in the materials and replaced by something simpler.
Effect Replaced(const Scene& scene, const char* name, std::initializer_list<Repair> kinds,
                const char* replacement, const char* noun = "material") {
  Effect effect{name, false, {}, {}, {}};
  uint64_t count = 0;
  for (const RepairReport::Entry& entry : scene.repairs.entries) {
    for (const Repair kind : kinds) {
      if (entry.kind != ToText(kind)) continue;
      if (count == 0) effect.evidence = entry.example;
      count += entry.count;
    }
  }
  effect.present = count > 0;
  if (effect.present) {
    effect.evidence =
        fmt::format("{} {}{} ({})", count, noun, count == 1 ? "" : "s", effect.evidence);
    effect.decision = fmt::format("present, not simulated: {}", replacement);
  } else {
    effect.bound = 0.0;
    effect.evidence = fmt::format("no such {}", noun);
    effect.decision = "off";
  }
  return effect;
}

}  // namespace

std::vector<Effect> FindEffects(const Hierarchy& hierarchy) {
  const Scene& scene = hierarchy.scene();
  return {
      ColourChannels(hierarchy),
      Occlusion(hierarchy),
      Interreflection(hierarchy),
      TwoSided(hierarchy),
      Replaced(scene, "textures", {Repair::kMap, Repair::kNoMap}, "the mean counts"),
      Replaced(scene, "emission maps", {Repair::kEmissionMap}, "the mean counts"),
      Replaced(scene, "opacity maps", {Repair::kOpacityMap}, "taken as opaque"),
      Replaced(scene, "mirrors", {Repair::kMirror}, "taken as diffuse, with Kd"),
      Replaced(scene, "gloss", {Repair::kGlossy}, "taken as diffuse, with Kd"),
      Replaced(scene, "clear glass", {Repair::kGlass}, "taken as opaque and diffuse, with Kd"),
      Replaced(scene, "lights without area", {Repair::kLight}, "left out", "light"),
  };
}

}  // namespace isolux
