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

// The same effect where maps are followed: on whatever is replaced beside.
Effect Mapped(const Scene& scene, TextureUse Material::*use, Effect replaced) {
  uint64_t polygons = 0, materials = 0;
  for (const Polygon& polygon : scene.polygons) {
    const bool varies = (scene.materials[polygon.material].*use).texture != kNoTexture;
    if (varies && polygon.coordinates != kNoCoordinates) ++polygons;
  }
  if (polygons == 0) return replaced;
  for (const Material& material : scene.materials) {
    if ((material.*use).texture != kNoTexture) ++materials;
  }
  Effect effect{.name = replaced.name, .present = true};
  effect.support = Support::kFixed;
  effect.evidence =
      fmt::format("{} material{} on {} polygons", materials, materials == 1 ? "" : "s", polygons);
  if (replaced.present) effect.evidence += "; by their mean: " + replaced.evidence;
  effect.reason = "means over elements carry the light, output shows the map";
  return effect;
}

}  // namespace

Effect DetectTextures(const Hierarchy& hierarchy) {
  const Scene& scene = hierarchy.scene();
  Effect effect = Mapped(scene, &Material::reflectance_map,
                         Replaced(scene, "textures", {"reflectance maps", "maps missing"},
                                  "material", "the mean of the map counts"));
  if (effect.present && effect.support == Support::kNotSimulated) return effect;
  effect.support = Support::kSwitchable;
  effect.bound = BoundOfTextures(hierarchy);
  return effect;
}

Effect DetectEmissionMaps(const Scene& scene) {
  return Mapped(scene, &Material::exitance_map,
                Replaced(scene, "emission-maps", {"emission maps"}, "material",
                         "the mean of the map counts"));
}

Effect DetectOpacityMaps(const Scene& scene) {
  return Replaced(scene, "opacity-maps", {"opacity maps"}, "material", "taken as opaque");
}

Effect DetectReplacedMirrors(const Scene& scene) {
  return Replaced(scene, "mirrors", {"mirror materials"}, "material", "taken as diffuse, with Kd");
}

Effect DetectReplacedGlass(const Scene& scene) {
  return Replaced(scene, "clear-glass", {"glass materials"}, "material",
                  "taken as opaque and diffuse, with Kd");
}

}  // namespace isolux
