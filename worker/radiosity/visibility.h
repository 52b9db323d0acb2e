// How much of a link is visible: one packet of eight rays between stratified points of its two
// ends, seeded by the ends' ids.
#pragma once

#include <vector>

#include "worker/radiosity/polygon_sampler.h"
#include "worker/radiosity/ray_scene.h"
#include "worker/radiosity/tree.h"

namespace isolux {

struct SampledVisibility {
  double share = 0;  // kernel-weighted share of the unoccluded coupling, in [0, 1]
  int visible = 0;  // rays of eight that passed; pairs of points that face away count like the rest
  int traced = 0;
};

// Picks surfaces of clusters, in proportion to their areas.
class NodeSampler {
 public:
  explicit NodeSampler(const Tree& tree);

  // Index of a surface of the cluster, for w in [0, 1).
  uint32_t Surface(const Tree& tree, uint32_t cluster, double w) const;

 private:
  std::vector<double> area_before_;  // of surfaces, in the hierarchy's order; one more at the end
};

// The rays of one packet, with what each carries; those that face away do not count.
struct SampledRays {
  RayPacket packet;
  FloatLanes weight{};
};
// Between p and q, or p and an image of q, whose points the goals then are.
inline constexpr uint32_t kStraight = 0xffffffffu;
SampledRays RaysBetween(const Tree& tree, const NodeSampler& sampler, const RayScene& rays,
                        uint32_t image, uint32_t p, uint32_t q, uint64_t seed);

SampledVisibility SampleVisibility(const Tree& tree, const NodeSampler& sampler,
                                   const RayScene& rays, uint32_t p, uint32_t q, uint64_t seed);

// The same of p and an image of q; what misses a mirror is hidden. `look`: whether anything may
// stand in the way.
SampledVisibility SampleThrough(const Tree& tree, const NodeSampler& sampler, const RayScene& rays,
                                uint32_t image, uint32_t p, uint32_t q, bool look, uint64_t seed);

}  // namespace isolux
