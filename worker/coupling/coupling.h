// Unoccluded coupling factors of two polygons, to a tolerance. For refinement, which asks for many
// at a coarse tolerance, and for tables of factors, which ask for fine ones.
//
//   C_pq = ∫∫ cosθ_p cosθ_q / (π d²) dA_q dA_p  =  A_p F_pq  =  A_q F_qp
//
// Pure functions of the two polygons, the same bits on every machine and for both orders of the
// ends. Formulas, measured errors and costs: docs/numerics.md, "Coupling".
#pragma once

#include <cstdint>

#include "common/scene/scene.h"

namespace isolux {

// What is needed of an end, computed once a polygon. The polygon must outlive it.
struct CouplingEnd {
  const ConvexPolygon* polygon = nullptr;
  Vec3 normal{0.0};
  Vec3 centre{0.0};  // of the area
  double area_m2 = 0;
  double radius_m = 0;  // about the centre
};
CouplingEnd MakeCouplingEnd(const ConvexPolygon& polygon);

// The rule that a coupling came from, the cheapest first.
enum class Regime : uint8_t {
  kZero,        // neither sees the front of the other: exactly 0
  kNegligible,  // the upper bound is below the tolerance
  kMidpoint,    // kernel at the centres
  kKernel,      // kernel at 3 (triangle) or 4 (quad) points of both
  kPoints,      // closed form of the larger from 3 or 4 points of the smaller
  kManyPoints,  // the same from 7 or 9 points
  kContour,     // adaptive contour integral
};
inline constexpr int kRegimes = 7;

struct PairCoupling {
  double coupling_m2 = 0;  // in [0, min(A_p, A_q)]
  double error_m2 = 0;     // estimate of the error of coupling_m2
  Regime regime = Regime::kZero;
  // Of a contour integral, the pieces of edges that it took, some 75 ns each; 0 of other rules.
  uint32_t pieces = 0;
};

// Within `tolerance_m2` (> 0) of the truth, but for one pair in a thousand, and for what double
// precision leaves: about 1e-15 of the product of the polygons' lengths.
PairCoupling Couple(const CouplingEnd& p, const CouplingEnd& q, double tolerance_m2);

}  // namespace isolux
