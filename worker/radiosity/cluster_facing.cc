#include "worker/radiosity/cluster_facing.h"

#include <algorithm>

namespace isolux {

const std::array<Vec3, kDirections>& Directions() {
  static const std::array<Vec3, kDirections> directions = [] {
    std::array<Vec3, kDirections> d;
    for (int axis = 0; axis < 3; ++axis) {
      d[2 * axis] = Vec3(0.0);
      d[2 * axis][axis] = 1;
      d[2 * axis + 1] = -d[2 * axis];
    }
    constexpr double kThird = 0.57735026918962576451;  // √(1/3)
    for (int k = 0; k < 4; ++k) {
      d[6 + 2 * k] = kThird * Vec3((k & 1) != 0 ? -1 : 1, (k & 2) != 0 ? -1 : 1, 1);
      d[7 + 2 * k] = -d[6 + 2 * k];
    }
    return d;
  }();
  return directions;
}

int NearestDirection(const Vec3& v) {
  // Of each opposite pair the size of the product decides which pair, its sign which of the two.
  int best = 0;
  double most = 0;
  for (int d = 0; d < kDirections; d += 2) {
    const double along = glm::dot(Directions()[d], v);
    if (std::abs(along) <= most) continue;
    most = std::abs(along);
    best = along < 0 ? d + 1 : d;
  }
  return best;
}

ClusterFacing::ClusterFacing(const Hierarchy& hierarchy, std::span<const uint32_t> component_of,
                             const TranslucentSheets* sheets) {
  const auto clusters = hierarchy.clusters();
  RankComponents(hierarchy, component_of, sheets);
  ListLit(hierarchy);
  area_m2_.assign(clusters.size(), {});
  cosine_.assign(hierarchy.surfaces().size(), {});
  for (uint32_t s = 0; s < cosine_.size(); ++s) {
    if (!StandsFor(hierarchy.cluster_of(s), s)) continue;
    const Vec3 n = hierarchy.geometry(s).Normal();
    for (int d = 0; d < kDirections; ++d) {
      cosine_[s][d] = static_cast<float>(std::max(0.0, glm::dot(n, Directions()[d])));
    }
  }
  for (uint32_t c = static_cast<uint32_t>(clusters.size()); c-- > 0;) {
    const Cluster& cluster = clusters[c];
    for (int d = 0; d < kDirections; ++d) {
      double& sum = area_m2_[c][d];
      for (uint32_t i = 0; i < cluster.child_count; ++i) {
        sum += part_m2(c, cluster.first_child + i, d);
      }
      if (cluster.child_count > 0) continue;
      for (uint32_t i = 0; i < cluster.surface_count; ++i) {
        const uint32_t s = hierarchy.surface_order()[cluster.first_surface + i];
        sum += hierarchy.surface_area_m2(s) * static_cast<double>(cosine_[s][d]);
      }
    }
  }
}

void ClusterFacing::RankComponents(const Hierarchy& hierarchy,
                                   std::span<const uint32_t> component_of,
                                   const TranslucentSheets* sheets) {
  const size_t n = hierarchy.surfaces().size();
  rank_of_surface_.assign(n, 0);
  lit_count_ = 1;
  if (component_of.empty()) return;
  struct Component {
    uint32_t lowest = 0;
    bool lit = false;
    double area_m2 = 0;
  };
  std::vector<Component> components(n);
  for (uint32_t s = 0; s < n; ++s) {
    Component& component = components[component_of[s]];
    const Rgb& exitance = hierarchy.surfaces()[s].exitance;
    component.lit |= exitance.x > 0 || exitance.y > 0 || exitance.z > 0;
    component.area_m2 += hierarchy.surface_area_m2(s);
  }
  // What is lit on one side of a sheet is lit on the other.
  for (bool more = sheets != nullptr && !sheets->empty(); more;) {
    more = false;
    for (uint32_t s = 0; s < n; ++s) {
      const uint32_t behind = sheets->PartnerOf(s);
      if (behind == TranslucentSheets::kNone || components[component_of[s]].lit) continue;
      if (!components[component_of[behind]].lit) continue;
      components[component_of[s]].lit = more = true;
    }
  }
  for (uint32_t s = 0; s < n; ++s) components[s].lowest = s;
  std::erase_if(components, [](const Component& c) { return !(c.area_m2 > 0); });
  std::sort(components.begin(), components.end(), [](const Component& a, const Component& b) {
    if (a.lit != b.lit) return a.lit;
    return a.area_m2 != b.area_m2 ? a.area_m2 > b.area_m2 : a.lowest < b.lowest;
  });
  std::vector<uint32_t> rank_of(n, 0);
  lit_count_ = 0;
  for (uint32_t r = 0; r < components.size(); ++r) {
    rank_of[components[r].lowest] = r;
    lit_count_ += components[r].lit ? 1 : 0;
  }
  for (uint32_t s = 0; s < n; ++s) rank_of_surface_[s] = rank_of[component_of[s]];
}

void ClusterFacing::ListLit(const Hierarchy& hierarchy) {
  const auto clusters = hierarchy.clusters();
  rank_.assign(clusters.size(), 0);
  first_lit_.assign(1, 0);
  std::vector<uint32_t> below;
  for (uint32_t c = 0; c < clusters.size(); ++c) {
    below.clear();
    for (uint32_t i = 0; i < clusters[c].surface_count; ++i) {
      const uint32_t s = hierarchy.surface_order()[clusters[c].first_surface + i];
      below.push_back(rank_of_surface_[s]);
    }
    std::sort(below.begin(), below.end());
    below.erase(std::unique(below.begin(), below.end()), below.end());
    if (!below.empty()) rank_[c] = below.front();
    for (const uint32_t rank : below) {
      if (rank < lit_count_) lit_.push_back(rank);
    }
    first_lit_.push_back(static_cast<uint32_t>(lit_.size()));
  }
}

Meeting ClusterFacing::OfClusters(uint32_t a, uint32_t b) const {
  const std::span<const uint32_t> x = LitBelow(a), y = LitBelow(b);
  const bool same = rank_[a] == rank_[b];
  // The one that both stand for is the first in both lists; any other in both is not stood for.
  for (size_t i = 0, k = 0; i < x.size() && k < y.size();) {
    if (x[i] == y[k] && !(same && x[i] == rank_[a])) return Meeting::kPart;
    const bool first = x[i] <= y[k], second = y[k] <= x[i];
    i += first ? 1 : 0;
    k += second ? 1 : 0;
  }
  return same ? Meeting::kAll : Meeting::kNothing;
}

Meeting ClusterFacing::OfClusterAndSurface(uint32_t cluster, uint32_t surface) const {
  if (StandsFor(cluster, surface)) return Meeting::kAll;
  const auto lit = LitBelow(cluster);
  return std::binary_search(lit.begin(), lit.end(), rank_of_surface_[surface]) ? Meeting::kPart
                                                                               : Meeting::kNothing;
}

}  // namespace isolux
