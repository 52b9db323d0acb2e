// How clusters look from different sides. A cluster has no normal; what it sends and receives
// depends on the direction, and is kept apart for fourteen: the axes and the diagonals of a cube.
//
//   S_c(d) = Σ A_s max(0, n_s·ω_d)  over the surfaces s below c: the area that faces ω_d, m²
//
// Radiosity is averaged with these weights on the way up, irradiance handed out with them on the
// way down, so that couplings through clusters stay symmetric and conserve power (after clusters
// without directions: [SmitsArvoGreenberg94]).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/hierarchy/hierarchy.h"

namespace isolux {

// Unit vectors; those of d and d ^ 1 are opposite.
const std::array<Vec3, kDirections>& Directions();

// The nearest of them; opposite vectors have opposite directions. The zero vector has direction 0.
int NearestDirection(const Vec3& v);

class ClusterFacing {
 public:
  explicit ClusterFacing(const Hierarchy& hierarchy);

  double area_m2(uint32_t cluster, int direction) const { return area_m2_[cluster][direction]; }
  // max(0, n·ω) of a surface.
  double cosine(uint32_t surface, int direction) const { return cosine_[surface][direction]; }

 private:
  std::vector<std::array<double, kDirections>> area_m2_;
  std::vector<std::array<float, kDirections>> cosine_;
};

}  // namespace isolux
