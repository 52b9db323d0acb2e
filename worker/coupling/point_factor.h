// Form factor from a point to a polygon, in closed form: for the coupling of polygons and for
// irradiance at points.
#pragma once

#include <span>

#include "worker/coupling/lanes.h"

namespace isolux {

// Form factors from four points to a polygon ([Lambert60]; [BaumRushmeierWinget89], eq. 4):
//   F(x→Q) = −1/2π Σ_k γ_k n·(a_k × b_k)/|a_k × b_k|
// The points lie in one plane of normal `n`; Q lies wholly in front of that
// plane. The caller makes sure that each point is in front of Q's plane, or discards its lane.
// In [0, 1].
Lanes PointFormFactors(const Vec3x4& points, const Vec3& n, std::span<const Vec3> q);

}  // namespace isolux
