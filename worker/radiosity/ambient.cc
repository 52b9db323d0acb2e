#include "worker/radiosity/ambient.h"

#include <algorithm>

namespace isolux {
namespace {

struct Component {
  Rgb emitted{0.0}, lost{0.0}, irradiance{0.0};
};

// The start need not be better than that: as a share of what changed at first, and at most so
// often.
constexpr double kSettled = 1e-3;
constexpr int kMostPasses = 200;

// Irradiances that sheets, fluorescence and emitted light agree with, pass by pass.
void PassOn(const Hierarchy& hierarchy, const Scout& scout, const TranslucentSheets& sheets,
            const Fluorescence& fluorescence, std::span<const GivenIrradiance> given,
            std::vector<Component>& components) {
  const auto arriving_at = [&](uint32_t s) {
    const Rgb& ambient = components[scout.component[s]].irradiance;
    return given.empty() ? ambient : ambient + given[s].mean;
  };
  std::vector<Rgb> emitted(components.size());
  double first = 0;
  for (int pass = 0; pass < kMostPasses; ++pass) {
    for (size_t c = 0; c < components.size(); ++c) emitted[c] = components[c].emitted;
    for (uint32_t s = 0; s < components.size(); ++s) {
      const uint32_t behind = sheets.PartnerOf(s);
      Rgb passed = fluorescence.Of(s).Of(arriving_at(s));
      if (behind != TranslucentSheets::kNone) {
        passed += sheets.TransmittanceOf(s) * arriving_at(behind);
      }
      emitted[scout.component[s]] +=
          hierarchy.surface_area_m2(s) * (1.0 - scout.escape[s]) * passed;
    }
    double changed = 0;
    for (size_t c = 0; c < components.size(); ++c) {
      Component& component = components[c];
      if (Sum(component.lost) == 0) continue;
      const Rgb before = component.irradiance;
      for (int k = 0; k < 3; ++k) {
        if (component.lost[k] > 0) component.irradiance[k] = emitted[c][k] / component.lost[k];
      }
      changed = std::max(changed, Sum(glm::abs(component.irradiance - before)));
    }
    first = std::max(first, changed);
    if (changed <= kSettled * first) return;
  }
}

}  // namespace

Snapshot AmbientSnapshot(const Hierarchy& hierarchy, const Scout& scout,
                         std::span<const GivenIrradiance> given, const TranslucentSheets& sheets,
                         const Fluorescence& fluorescence) {
  const auto surfaces = hierarchy.surfaces();
  std::vector<Component> components(surfaces.size());  // by its lowest surface
  for (uint32_t s = 0; s < surfaces.size(); ++s) {
    Component& component = components[scout.component[s]];
    const double area = hierarchy.surface_area_m2(s), escape = scout.escape[s];
    component.emitted += area * (1 - escape) * surfaces[s].exitance;
    if (!given.empty()) {
      component.emitted += area * (1 - escape) * surfaces[s].reflectance * given[s].mean;
    }
    component.lost += area * (1.0 - surfaces[s].reflectance + surfaces[s].reflectance * escape);
  }
  for (Component& component : components) {
    for (int c = 0; c < 3; ++c) {
      if (component.lost[c] > 0) component.irradiance[c] = component.emitted[c] / component.lost[c];
    }
  }
  if (!sheets.empty() || !fluorescence.empty()) {
    PassOn(hierarchy, scout, sheets, fluorescence, given, components);
  }
  Snapshot snapshot;
  snapshot.leaves.resize(surfaces.size());
  for (uint32_t s = 0; s < surfaces.size(); ++s) {
    LeafRecord& leaf = snapshot.leaves[s];
    leaf.id = {s, 1};
    leaf.escape = scout.escape[s];
    const Component& component = components[scout.component[s]];
    for (int c = 0; c < 3; ++c) {
      leaf.irradiance[c] = component.irradiance[c];
      if (!given.empty()) leaf.irradiance[c] += given[s].mean[c];
    }
  }
  return snapshot;
}

}  // namespace isolux
