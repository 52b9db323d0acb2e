// How clusters look from different sides. A cluster has no normal; what it sends and receives
// depends on the direction, and is kept apart for fourteen: the axes and the diagonals of a cube.
//
//   S_c(d) = Σ A_s max(0, n_s·ω_d)  over the surfaces s that c stands for: the area that faces ω_d,
//   m²
//
// Radiosity is averaged with these weights on the way up, irradiance handed out with them on the
// way down, so that couplings through clusters stay symmetric and conserve power (after clusters
// without directions: [SmitsArvoGreenberg94]).
//
// A cluster has no inside either: eight rays between two of them do not tell the floor under a box
// from the floor beside it. So a cluster stands for one component of the scene alone, of those that
// its surfaces belong to the one that comes first in an order of the whole scene (those with light
// first, then the largest). Surfaces of other components neither send nor receive through it.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/hierarchy/hierarchy.h"
#include "common/hierarchy/translucent_sheets.h"

namespace isolux {

// Unit vectors; those of d and d ^ 1 are opposite.
const std::array<Vec3, kDirections>& Directions();

// The nearest of them; opposite vectors have opposite directions. The zero vector has direction 0.
int NearestDirection(const Vec3& v);

// What a link that ends in a cluster stands for of what its two ends exchange.
enum class Meeting : uint8_t {
  kNothing,  // the ends have no component in common, or one without light
  kPart,     // they have one that a cluster among them does not stand for
  kAll,
};

class ClusterFacing {
 public:
  // component_of: of each surface, the lowest surface of its component (Scout::component); empty
  // where all are one. What comes through `sheets` (may be null) is light too.
  explicit ClusterFacing(const Hierarchy& hierarchy, std::span<const uint32_t> component_of = {},
                         const TranslucentSheets* sheets = nullptr);

  double area_m2(uint32_t cluster, int direction) const { return area_m2_[cluster][direction]; }
  // What a cluster of a cluster adds to its area.
  double part_m2(uint32_t cluster, uint32_t child, int direction) const {
    return rank_[child] == rank_[cluster] ? area_m2_[child][direction] : 0.0;
  }
  // max(0, n·ω) of a surface; 0 where the cluster that holds it does not stand for it.
  double cosine(uint32_t surface, int direction) const { return cosine_[surface][direction]; }

  // Whether the cluster, one of those above the surface, stands for it.
  bool StandsFor(uint32_t cluster, uint32_t surface) const {
    return rank_[cluster] == rank_of_surface_[surface];
  }
  Meeting OfClusters(uint32_t a, uint32_t b) const;
  Meeting OfClusterAndSurface(uint32_t cluster, uint32_t surface) const;
  // Whether surfaces of more than one component with light are below.
  bool IsMixed(uint32_t cluster) const { return LitBelow(cluster).size() > 1; }

 private:
  void RankComponents(const Hierarchy& hierarchy, std::span<const uint32_t> component_of,
                      const TranslucentSheets* sheets);
  void ListLit(const Hierarchy& hierarchy);
  std::span<const uint32_t> LitBelow(uint32_t cluster) const {
    return std::span(lit_).subspan(first_lit_[cluster],
                                   first_lit_[cluster + 1] - first_lit_[cluster]);
  }

  uint32_t lit_count_ = 0;                 // components of lower rank have light
  std::vector<uint32_t> rank_of_surface_;  // of the component in the order
  std::vector<uint32_t> rank_;             // what each cluster stands for: the least of those below
  std::vector<uint32_t> lit_;              // ranks of components with light, sorted, by cluster
  std::vector<uint32_t> first_lit_;
  std::vector<std::array<double, kDirections>> area_m2_;
  std::vector<std::array<float, kDirections>> cosine_;
};

}  // namespace isolux
