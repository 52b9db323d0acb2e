#include "worker/radiosity/ambient.h"

namespace isolux {

Snapshot AmbientSnapshot(const Hierarchy& hierarchy, const Scout& scout,
                         std::span<const GivenIrradiance> given) {
  const auto surfaces = hierarchy.surfaces();
  struct Component {
    Rgb emitted{0.0}, lost{0.0};
  };
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
  Snapshot snapshot;
  snapshot.leaves.resize(surfaces.size());
  for (uint32_t s = 0; s < surfaces.size(); ++s) {
    LeafRecord& leaf = snapshot.leaves[s];
    leaf.id = {s, 1};
    leaf.escape = scout.escape[s];
    const Component& component = components[scout.component[s]];
    for (int c = 0; c < 3; ++c) {
      if (component.lost[c] > 0) leaf.irradiance[c] = component.emitted[c] / component.lost[c];
      if (!given.empty()) leaf.irradiance[c] += given[s].mean[c];
    }
  }
  return snapshot;
}

}  // namespace isolux
