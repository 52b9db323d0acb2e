// The coupling factor of two polygons as an integral along their outlines: for polygons that are
// near each other or touch. For coupling.cc.
#pragma once

#include <cstdint>
#include <span>

#include "common/vec.h"

namespace isolux {

struct ContourIntegral {
  double coupling = 0;  // not clamped
  double error = 0;     // estimate
  uint32_t pieces = 0;  // of edges, each integrated against one of the other polygon
};

// C = 1/2π Σ_e Σ_f u_e·u_f ∫_e ∫_f ln r, over the edges e of p and f of q [Sparrow63]. Both are
// counter-clockwise about their own normals, have at most five corners, lie wholly in front of the
// other's plane and within the unit ball or little more; p should be the smaller.
ContourIntegral IntegrateContours(std::span<const Vec3> p, std::span<const Vec3> q,
                                  double tolerance);

}  // namespace isolux
