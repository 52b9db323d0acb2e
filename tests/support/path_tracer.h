// Irradiance by path tracing. Shares no transport with the solver: no hierarchy of links, no form
// factors; only the geometry of the scene and its rays.
#pragma once

#include <cstdint>
#include <vector>

#include "client/output/reference_points.h"
#include "common/scene/scene.h"
#include "common/util/parallel.h"

namespace isolux::testing {

struct PathTracing {
  uint64_t points = 400;  // uniform over the surfaces
  double error = 0.003;   // standard error of a point to reach, over its irradiance (or over a
                          // twentieth of the mean, if that is more)
  double seconds = 60;    // after which it ends in any case
  uint64_t seed = 7;
  bool by_mirrors_alone = false;  // light that met a mirror on its way, nothing else
};

// Paths are added until all points are good enough.
std::vector<ReferencePoint> TracePaths(const Scene& scene, const PathTracing& options,
                                       ThreadPool& pool);

// Mean standard error of the points over their mean irradiance.
double NoiseOf(const std::vector<ReferencePoint>& points);

}  // namespace isolux::testing
