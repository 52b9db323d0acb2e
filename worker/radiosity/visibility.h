// How much of a link is visible: one packet of eight rays between stratified points of its two
// ends, seeded by the ends' ids.
#pragma once

#include <vector>

#include "worker/radiosity/ray_scene.h"
#include "worker/radiosity/tree.h"

namespace isolux {

struct SampledVisibility {
  double share = 0;  // kernel-weighted share of the unoccluded coupling, in [0, 1]
  int visible = 0;  // rays of eight that passed; pairs of points that face away count like the rest
  int traced = 0;
};

// Points on nodes, uniform in area.
class NodeSampler {
 public:
  explicit NodeSampler(const Tree& tree);

  struct Point {
    Vec3 position{0.0};
    Vec3 normal{0.0};
    uint32_t polygon = 0;
    uint32_t surface = 0;
  };
  // u, v, w in [0, 1): w picks the surface of a cluster.
  Point Sample(const Tree& tree, uint32_t node, double u, double v, double w) const;

 private:
  std::vector<double> area_before_;  // of surfaces, in the hierarchy's order; one more at the end
};

// Uniform point of a triangle or quad.
Vec3 SamplePolygon(const ConvexPolygon& polygon, double u, double v);

// The share of the way to the centroid by which points of a polygon are drawn in, a quarter at
// most, so that none is nearer to a side than twice the noise (RayScene::coordinate_noise_m).
// Things stand along sides, and rays from points within the noise would pass through them.
double InsideShare(const ConvexPolygon& polygon, const Vec3& centre, double noise_m);
// The polygon drawn in by that share.
ConvexPolygon DrawnIn(const ConvexPolygon& polygon, double noise_m);

SampledVisibility SampleVisibility(const Tree& tree, const NodeSampler& sampler,
                                   const RayScene& rays, uint32_t p, uint32_t q, uint64_t seed);

}  // namespace isolux
