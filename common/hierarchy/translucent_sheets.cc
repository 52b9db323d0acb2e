#include "common/hierarchy/translucent_sheets.h"

#include <algorithm>
#include <cmath>

#include "common/scene/translucency.h"

namespace isolux {

TranslucentSheets::TranslucentSheets(const Hierarchy& hierarchy, const EffectsPlan& plan) {
  if (!plan.sheets) return;
  const Scene& scene = hierarchy.scene();
  const auto surfaces = hierarchy.surfaces();
  for (uint32_t s = 1; s < surfaces.size(); ++s) {
    const uint32_t polygon = surfaces[s].polygon;
    if (surfaces[s - 1].polygon != polygon || !IsSheet(scene, scene.polygons[polygon])) continue;
    if (partner_.empty()) {
      partner_.assign(surfaces.size(), kNone);
      transmittance_.assign(surfaces.size(), Rgb(0.0));
    }
    partner_[s] = s - 1;
    partner_[s - 1] = s;
    transmittance_[s] = transmittance_[s - 1] =
        scene.materials[scene.polygons[polygon].material].transmittance;
  }
}

std::vector<TranslucentSheets::Behind> TranslucentSheets::BehindLeaves(
    std::span<const LeafRecord> leaves) const {
  std::vector<Behind> behind;
  if (empty()) return behind;
  behind.resize(leaves.size());
  for (size_t i = 0; i < leaves.size(); ++i) {
    if (PartnerOf(leaves[i].id.surface) == kNone) continue;
    const NodeId wanted = PartnerOf(leaves[i].id);
    // The first leaf that is the piece, or lies in it or above it.
    auto at = std::lower_bound(leaves.begin(), leaves.end(), wanted,
                               [](const LeafRecord& a, const NodeId& b) { return a.id < b; });
    const bool is_coarser = at == leaves.end() || !Contains(wanted, at->id);
    if (is_coarser && at != leaves.begin()) --at;
    double whole = 0;
    for (; at != leaves.end() && (Contains(wanted, at->id) || Contains(at->id, wanted)); ++at) {
      const double share = std::ldexp(1.0, -std::max(0, at->id.level() - wanted.level()));
      for (int c = 0; c < 3; ++c) behind[i].irradiance[c] += share * at->irradiance[c];
      behind[i].spread += share * at->spread;
      whole += share;
      if (is_coarser) break;
    }
    if (!(whole > 0) || whole == 1) continue;
    for (double& h : behind[i].irradiance) h /= whole;
    behind[i].spread /= whole;
  }
  return behind;
}

}  // namespace isolux
