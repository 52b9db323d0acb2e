#include "common/hierarchy/passed_light.h"

#include <algorithm>

namespace isolux {
namespace {

double LargestOf(const Rgb& c) { return std::max({c.x, c.y, c.z}); }

Rgb ToRgb(const std::array<double, 3>& h) { return {h[0], h[1], h[2]}; }

}  // namespace

std::vector<PassedLight> PassedLightOf(const Snapshot& snapshot, const TranslucentSheets* sheets,
                                       const Fluorescence* fluorescence) {
  const std::vector<LeafRecord>& leaves = snapshot.leaves;
  std::vector<PassedLight> passed = snapshot.handed_on;
  if (sheets == nullptr && fluorescence == nullptr) return passed;
  passed.resize(leaves.size());
  if (sheets != nullptr) {
    const std::vector<TranslucentSheets::Behind> behind = sheets->BehindLeaves(leaves);
    for (size_t i = 0; i < behind.size(); ++i) {
      const Rgb& tau = sheets->TransmittanceOf(leaves[i].id.surface);
      passed[i].radiosity += tau * ToRgb(behind[i].irradiance);
      passed[i].spread += LargestOf(tau) * behind[i].spread;
    }
  }
  if (fluorescence == nullptr) return passed;
  for (size_t i = 0; i < leaves.size(); ++i) {
    const Reradiation& reradiation = fluorescence->Of(leaves[i].id.surface);
    if (!reradiation.exists()) continue;
    passed[i].radiosity += reradiation.Of(ToRgb(leaves[i].irradiance));
    passed[i].spread += LargestOf(reradiation.Taken()) * leaves[i].spread;
  }
  return passed;
}

}  // namespace isolux
