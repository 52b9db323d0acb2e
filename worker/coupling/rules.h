// The quadrature rules of a coupling for polygons some way apart: kernel at points of both, closed
// form at points of one. For coupling.cc.
#pragma once

#include <span>

#include "worker/coupling/coupling.h"

namespace isolux {

// κ, the radii over the distance, up to which an exchange below the tolerance is left at the
// centroid rule, and up to which the kernel rules are tried at all.
inline constexpr double kNegligibleKappa = 0.5;
inline constexpr double kKernelKappa = 0.35;
// Error of the centroid rule: this times κ² A_p A_q/(π d²). A bound in practice: measured on random
// pairs.
inline constexpr double kMidpointError = 2;

// A convex polygon of three to five corners, in any units of length, wholly in front of the plane
// of the other of its pair.
struct Shape {
  std::span<const Vec3> corners;
  Vec3 normal{0.0};
  Vec3 centre{0.0};
  double area = 0;
  double radius = 0;
};

// Kernel rules. False, and nothing in `result`, where the pair is too near for them at this
// tolerance.
bool TryKernelRules(const Shape& p, const Shape& q, double tolerance, PairCoupling& result);

// Lambert's form of q from points of p, which is the smaller. False where that is not good enough.
bool TryPointRules(const Shape& p, const Shape& q, double tolerance, PairCoupling& result);

}  // namespace isolux
