#include "server/handed_on.h"

#include <algorithm>
#include <cmath>

#include "common/hierarchy/fluorescence.h"
#include "common/util/exact_sum.h"

namespace isolux {
namespace {

// What is taken in a channel of one group and given out in a channel of another.
double ShareBetween(const BandReradiation& reradiation, uint32_t from_group, int from,
                    uint32_t to_group, int to) {
  const uint32_t from_band = BandInChannel(reradiation.bands, from_group, from);
  const uint32_t to_band = BandInChannel(reradiation.bands, to_group, to);
  if (from_band >= reradiation.bands || to_band >= reradiation.bands) return 0;
  return reradiation.Share(from_band, to_band);
}

}  // namespace

HandingOn::HandingOn(const Hierarchy& hierarchy, const Snapshot& leaves, const EffectsPlan& plan)
    : hierarchy_(hierarchy), leaves_(leaves) {
  if (!plan.fluorescence) return;
  for (const Surface& surface : hierarchy.surfaces()) {
    of_surface_.push_back(&BandReradiationOf(hierarchy.scene(), surface));
  }
  for (uint32_t i = 0; i < leaves.leaves.size(); ++i) {
    if (of_surface_[leaves.leaves[i].id.surface]->exists()) fluorescent_.push_back(i);
  }
}

void HandingOn::Take(const Snapshot& solved, double error) {
  Taken& taken = groups_.emplace_back();
  taken.error = error;
  for (const uint32_t i : fluorescent_) {
    taken.irradiance.push_back(solved.leaves[i].irradiance);
    taken.spread.push_back(solved.leaves[i].spread);
  }
}

HandedOn HandingOn::ToNext() const {
  const auto group = static_cast<uint32_t>(groups_.size());
  HandedOn handed;
  if (fluorescent_.empty() || !IsHandedLight(hierarchy_.scene(), group)) return handed;
  handed.of_leaves.resize(leaves_.leaves.size());
  std::array<ExactSum, 3> power_w;
  ExactSum error_w;
  for (uint32_t before = 0; before < group; ++before) {
    const Taken& taken = groups_[before];
    for (size_t k = 0; k < taken.irradiance.size(); ++k) {
      const NodeId& id = leaves_.leaves[fluorescent_[k]].id;
      const double area_m2 = std::ldexp(hierarchy_.surface_area_m2(id.surface), -id.level());
      const BandReradiation& reradiation = *of_surface_[id.surface];
      PassedLight& out = handed.of_leaves[fluorescent_[k]];
      double largest = 0;
      for (int from = 0; from < 3; ++from) {
        double share = 0;
        for (int to = 0; to < 3; ++to) {
          const double given_out = ShareBetween(reradiation, before, from, group, to);
          const double radiosity = given_out * taken.irradiance[k][from];
          out.radiosity[to] += radiosity;
          power_w[to].Add(area_m2 * radiosity);
          error_w.Add(area_m2 * radiosity * taken.error);
          share += given_out;
        }
        largest = std::max(largest, share);
      }
      out.spread += largest * taken.spread[k];
    }
  }
  for (int c = 0; c < 3; ++c) handed.power_w[c] = power_w[c].Value();
  handed.error_w = error_w.Value();
  return handed;
}

double HandingOn::Radiosity(uint32_t surface, uint32_t band,
                            std::span<const float> irradiance) const {
  if (of_surface_.empty()) return 0;
  double sum = 0;
  for (uint32_t from = 0; from < band - band % kBandsOfGroup; ++from) {
    sum += of_surface_[surface]->Share(from, band) * irradiance[from];
  }
  return sum;
}

}  // namespace isolux
