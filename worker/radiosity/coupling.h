// Unoccluded coupling factors of two polygons, and how much the form factor varies over each of
// them.
//
//   C_pq = ∫∫ cosθ_p cosθ_q / (π d²) dA_q dA_p  =  A_p F_pq  =  A_q F_qp
//
// Pure functions of the two polygons. The caller gives the pair in the order of their ids, so that
// C_pq and C_qp are one number. Formulas: docs/design.md, "Coupling".
#pragma once

#include <array>
#include <span>

#include "common/scene/scene.h"
#include "worker/radiosity/lanes.h"

namespace isolux {

// A convex polygon cut by a half-space: up to five corners.
struct ClippedPolygon {
  int count = 0;
  std::array<Vec3, 5> v{};

  double Area() const;
};

// The part of `polygon` in front of the plane through `point` with this normal; corners within
// `tolerance_m` of the plane count as on it. Empty (count 0) where nothing is in front.
ClippedPolygon ClipToFront(const ConvexPolygon& polygon, const Vec3& point, const Vec3& normal,
                           double tolerance_m);

// Form factors from four points to a polygon (Lambert 1760; Baum et al. 1989, eq. 4):
//   F(x→Q) = −1/2π Σ_k γ_k n·(a_k × b_k)/|a_k × b_k|
// The points lie in one plane of normal `n`; Q lies wholly in front of that plane. The caller makes
// sure that each point is in front of Q's plane, or discards its lane. In [0, 1].
Lanes PointFormFactors(const Vec3x4& points, const Vec3& n, std::span<const Vec3> q);

struct PolygonCoupling {
  double coupling_m2 =
      0;                // in [0, min(A_p, A_q)]; 0 exactly where the polygons cannot see each other
  double error_m2 = 0;  // estimate of the error of coupling_m2
  double variation_p = 0;  // largest minus smallest F(x→q) over points x of p
  double variation_q = 0;  // largest minus smallest F(y→p) over points y of q
};

// What is needed of an end, computed once a node.
struct CouplingEnd {
  const ConvexPolygon* polygon = nullptr;
  Vec3 normal{0.0};
  Vec3 centre{0.0};
  double area_m2 = 0;
  double radius_m = 0;  // about the centre
};
CouplingEnd MakeCouplingEnd(const ConvexPolygon& polygon);

PolygonCoupling Couple(const CouplingEnd& p, const CouplingEnd& q);

}  // namespace isolux
