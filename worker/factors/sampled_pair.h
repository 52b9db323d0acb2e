// The visible share of a pair by sampled segments: the last resort, where so many occluders stand
// between two polygons that clipping them costs more.
#pragma once

#include <cstdint>

#include "worker/visibility/occluder_tree.h"

namespace isolux {

inline constexpr uint32_t kMostSegments = 1 << 16;

struct VisibleShare {
  double value = 0;  // of the unobstructed coupling, in [0, 1]
  double error = 1;  // stated: three standard errors
  uint32_t segments = 0;
};

// Points of a Sobol sequence in four dimensions ([JoeKuo08]), scrambled ([Owen97], by hashing:
// [Burley20]) in sixteen independent ways, whose scatter is the error; as many as it takes to come
// below `tolerance`, at most kMostSegments. `unobstructed_m2`: the coupling without occluders, of
// which the share is; it decides how segments are drawn.
VisibleShare SampleVisibleShare(const ShaftEnd& p, const ShaftEnd& q, const OccluderTree& tree,
                                double unobstructed_m2, double tolerance, uint64_t seed);

// Dimension 0 … 3 of point `index`, scrambled by `seed`; in [0, 1).
double ScrambledSobol(uint32_t index, int dimension, uint32_t seed);

}  // namespace isolux
