// Which side of a polygon's plane another polygon is on.
#pragma once

#include <algorithm>
#include <cmath>

#include "worker/coupling/coupling.h"

namespace isolux {

// Corners so near the other's plane are in it: what rounding of the coordinates leaves, and a share
// of the pair's extent.
inline double PlaneTolerance(const CouplingEnd& p, const CouplingEnd& q) {
  const Vec3 d = q.centre - p.centre, s = q.centre + p.centre;
  const auto largest = [](const Vec3& v) {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  };
  return 1e-12 * (largest(d) + p.radius_m + q.radius_m) + 1e-15 * largest(s);
}

enum class Facing { kBehind, kFront, kCut };

// Of `other` and the plane of `end`. By the bounding sphere where that tells.
inline Facing FacingOf(const CouplingEnd& other, const CouplingEnd& end, double tolerance_m) {
  const double height = glm::dot(end.normal, other.centre - end.centre);
  if (height > other.radius_m + tolerance_m) return Facing::kFront;
  if (height < -other.radius_m - tolerance_m) return Facing::kBehind;
  bool front = false, behind = false;
  for (int i = 0; i < other.polygon->count; ++i) {
    const double corner = glm::dot(end.normal, other.polygon->v[i] - end.polygon->v[0]);
    front |= corner > tolerance_m;
    behind |= corner < -tolerance_m;
  }
  return !front ? Facing::kBehind : behind ? Facing::kCut : Facing::kFront;
}

}  // namespace isolux
