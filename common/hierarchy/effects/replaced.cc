#include <initializer_list>
#include <string_view>

#include "common/hierarchy/effects/detectors.h"

namespace isolux {
namespace {

// repairs: beginnings of what the importer calls the replacement (client/import/repair.cc).
Effect Replaced(const Scene& scene, const char* name,
                std::initializer_list<std::string_view> repairs, const char* noun,
                const char* replacement) {
  Effect effect{.name = name};
  effect.support = Support::kNotSimulated;
  uint64_t count = 0;
  std::string example;
  for (const RepairReport::Entry& entry : scene.repairs.entries) {
    for (const std::string_view repair : repairs) {
      if (!entry.kind.starts_with(repair)) continue;
      if (count == 0) example = entry.example;
      count += entry.count;
    }
  }
  effect.present = count > 0;
  if (effect.present) {
    effect.evidence = fmt::format("{} {}{} ({})", count, noun, count == 1 ? "" : "s", example);
    effect.reason = replacement;
  } else {
    effect.evidence = fmt::format("no such {}", noun);
    effect.bound = 0.0;
  }
  return effect;
}

}  // namespace

Effect DetectTextures(const Scene& scene) {
  return Replaced(scene, "textures", {"reflectance maps", "maps missing"}, "material",
                  "the mean of the map counts");
}

Effect DetectEmissionMaps(const Scene& scene) {
  return Replaced(scene, "emission-maps", {"emission maps"}, "material", "even emission counts");
}

Effect DetectOpacityMaps(const Scene& scene) {
  return Replaced(scene, "opacity-maps", {"opacity maps"}, "material", "taken as opaque");
}

Effect DetectMirrors(const Scene& scene) {
  return Replaced(scene, "mirrors", {"mirror materials"}, "material", "taken as diffuse, with Kd");
}

Effect DetectGloss(const Scene& scene) {
  return Replaced(scene, "gloss", {"glossy materials"}, "material", "taken as diffuse, with Kd");
}

Effect DetectClearGlass(const Scene& scene) {
  return Replaced(scene, "clear-glass", {"glass materials"}, "material",
                  "taken as opaque and diffuse, with Kd");
}

Effect DetectLights(const Scene& scene) {
  return Replaced(scene, "lights", {"lights without area"}, "light", "left out");
}

}  // namespace isolux
