// How much of a link is visible: one packet of eight rays between stratified points of its two
// ends, seeded by the ends' ids.
#pragma once

#include <span>

#include "worker/radiosity/polygon_sampler.h"
#include "worker/radiosity/ray_scene.h"
#include "worker/radiosity/tree.h"
#include "worker/visibility/occluder_rays.h"

namespace isolux {

struct SampledVisibility {
  double share = 0;  // kernel-weighted share of the unoccluded coupling, in [0, 1]
  int visible = 0;  // rays of eight that passed; pairs of points that face away count like the rest
  int traced = 0;
};

// Index of one of the surfaces that the cluster stands for, in proportion to the areas that face
// the direction, for w in [0, 1). The cluster has such area.
uint32_t SurfaceFacing(const Tree& tree, uint32_t cluster, int direction, double w);

// The rays of one packet, with what each carries; those that face away do not count.
struct SampledRays {
  RayPacket packet;
  FloatLanes weight{};
};
// Between p and q, or p and an image of q, whose points the goals then are.
inline constexpr uint32_t kStraight = 0xffffffffu;
SampledRays RaysBetween(const Tree& tree, const RayScene& rays, uint32_t image, uint32_t p,
                        uint32_t q, uint64_t seed);

// All that may stand between two ends, where that is known.
struct Obstacles {
  const OccluderRays& rays;
  std::span<const uint32_t> candidates;
};

// Where all eight pairs of points face away others are drawn, up to three times. `known` spares
// rays in the scene's tree; null: nothing is known.
SampledVisibility SampleVisibility(const Tree& tree, const RayScene& rays, uint32_t p, uint32_t q,
                                   uint64_t seed, const Obstacles* known = nullptr);

// The same of p and an image of q; what misses a mirror is hidden. `look`: whether anything may
// stand in the way.
SampledVisibility SampleThrough(const Tree& tree, const RayScene& rays, uint32_t image, uint32_t p,
                                uint32_t q, bool look, uint64_t seed);

}  // namespace isolux
