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

ClusterFacing::ClusterFacing(const Hierarchy& hierarchy) {
  const auto clusters = hierarchy.clusters();
  area_m2_.assign(clusters.size(), {});
  cosine_.resize(hierarchy.surfaces().size());
  for (uint32_t s = 0; s < cosine_.size(); ++s) {
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
        sum += area_m2_[cluster.first_child + i][d];
      }
      if (cluster.child_count > 0) continue;
      for (uint32_t i = 0; i < cluster.surface_count; ++i) {
        const uint32_t s = hierarchy.surface_order()[cluster.first_surface + i];
        sum += hierarchy.surface_area_m2(s) * static_cast<double>(cosine_[s][d]);
      }
    }
  }
}

}  // namespace isolux
