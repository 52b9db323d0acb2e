// What each effect took of a worker's time: stopwatches at the borders of phases, and within a
// phase counts times a mean that was measured. Parts do not overlap.
#pragma once

#include <span>

#include "common/scene/effect_costs.h"
#include "common/scene/effects_plan.h"
#include "common/util/parallel.h"
#include "worker/radiosity/refine.h"

namespace isolux {

// CPU time that a shadow ray takes, s: that of some of the rays of these links, cast once more.
// 0 where none can be.
double MeanRaySeconds(const RefineScene& scene, const Tree& tree, const LinkSet& links,
                      const ThreadPool& pool);

// Of refinement, which took this much: rays, and what goes by way of mirrors by its evaluations.
void AddRefineCosts(const RefineCounters& counters, double cpu_s, double ray_s, EffectCosts& costs);

// Which lights shine.
struct LightKinds {
  bool lights = false, sun = false, sky = false;
};
LightKinds KindsOf(const Scene& scene, const EffectsPlan& plan);
// Of lights by their rays; where none was cast in equal parts.
void AddLightCosts(const LightKinds& kinds, const LightRays& rays, double cpu_s,
                   EffectCosts& costs);

// CPU time of the parts of a solution, s.
struct SolveTimes {
  double maps_s = 0;     // means of textures
  double closure_s = 0;  // products of one channel
  uint32_t closure_products = 0;
  double solver_s = 0;
  uint32_t solver_products = 0;
  uint32_t again = 0;                // of them, after the first pass of what passes on light
  double mirrors = 0;                // share of the links that goes by way of mirrors
  double medium_s = 0, panes_s = 0;  // factors, and products that tell what is absorbed
};
// By number.
double ShareThroughMirrors(const LinkSet& links);
// Of all products of the solver the share of links by way of mirrors; of the rest, what is more
// than products of one channel take to colour; of what then is left all but the first product of
// the first pass to interreflection, later passes to sheets and fluorescence (both: halves).
void AddSolveCosts(const SolveTimes& times, const EffectsPlan& plan, bool sheets, bool fluorescence,
                   EffectCosts& costs);

// Of the gather, which took this much and has set the rays: rays times what a ray takes, those of
// lights `light_ray_s`.
void AddGatherCosts(double cpu_s, double ray_s, double light_ray_s, EffectCosts& costs);

}  // namespace isolux
