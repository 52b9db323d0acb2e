#include "worker/coupling/variation.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numbers>

#include "worker/coupling/clip.h"
#include "worker/coupling/facing.h"
#include "worker/coupling/point_factor.h"

namespace isolux {
namespace {

constexpr double kPi = std::numbers::pi;

// Below this (radii over distance), and where the centroid rule is good to this share of the
// smaller area, the other polygon is taken as a point.
constexpr double kFarKappa = 0.2;
constexpr double kFarTolerance = 1e-3;
// Ends whose radii together exceed this share of their distance can have most of their exchange
// near one point, which corner samples miss: the closest points are sampled too.
constexpr double kClosestPointsKappa = 0.7;

Vec3 Lerp(const Vec3& a, const Vec3& b, double t) { return a + t * (b - a); }

// Corners drawn in by a tenth; a triangle's fourth point is its centre.
Vec3x4 CornerSamples(const CouplingEnd& end) {
  std::array<Vec3, 4> points;
  for (int i = 0; i < 4; ++i) {
    points[i] = i < end.polygon->count ? Lerp(end.polygon->v[i], end.centre, 0.1) : end.centre;
  }
  return Vec3x4(points);
}

Vec3x4 Mix(const Vec3& at, double share, const Vec3x4& points) {
  return {points.x + share * (at.x - points.x), points.y + share * (at.y - points.y),
          points.z + share * (at.z - points.z)};
}

// The points of a convex polygon closest to four others.
Vec3x4 ClosestPoints(const ConvexPolygon& polygon, const Vec3& normal, const Vec3x4& x) {
  LaneMask inside = Splat(0.0) == 0.0;
  Lanes best = Splat(std::numeric_limits<double>::infinity());
  Vec3x4 closest = x;
  for (int i = 0; i < polygon.count; ++i) {
    const Vec3& a = polygon.v[i];
    const Vec3 side = polygon.v[(i + 1) % polygon.count] - a;
    const Vec3x4 off = x - a;
    inside &= Dot(glm::cross(normal, side), off) >= 0.0;
    const double length2 = glm::dot(side, side);
    const Lanes share =
        Minimum(Maximum(Dot(side, off) / (length2 > 0 ? length2 : 1.0), Splat(0.0)), Splat(1.0));
    const Vec3x4 away = {off.x - share * side.x, off.y - share * side.y, off.z - share * side.z};
    const Lanes distance2 = Dot(away, away);
    closest = Select(distance2 < best, x - away, closest);
    best = Minimum(best, distance2);
  }
  const Lanes height = Dot(normal, x - polygon.v[0]);
  const Vec3x4 below = {x.x - height * normal.x, x.y - height * normal.y, x.z - height * normal.z};
  return Select(inside, below, closest);
}

// Range of what was added, over all lanes.
struct Range {
  Lanes low = Splat(std::numeric_limits<double>::infinity());
  Lanes high = Splat(0.0);
  void Add(const Lanes& values) {
    low = Minimum(low, values);
    high = Maximum(high, values);
  }
  double Width() const {
    const double least = std::min(std::min(low[0], low[1]), std::min(low[2], low[3]));
    const double most = std::max(std::max(high[0], high[1]), std::max(high[2], high[3]));
    return most > least ? most - least : 0.0;
  }
};

// Kernel cosθ cosθ'/(π d²) times the area of the source, from four points to one.
Lanes KernelFactors(const Vec3x4& points, const Vec3& n, const CouplingEnd& source) {
  const Vec3x4 d = source.centre - points;
  const Lanes d2 = Dot(d, d);
  const Lanes cosines =
      Maximum(Dot(n, d), Splat(0.0)) * Maximum(-Dot(source.normal, d), Splat(0.0));
  return cosines * source.area_m2 / (kPi * d2 * d2);
}

double FarVariation(const CouplingEnd& p, const CouplingEnd& q) {
  Range range;
  range.Add(KernelFactors(CornerSamples(p), p.normal, q));
  return range.Width();
}

// F from points in the plane of p to q (already in front of that plane); 0 for points behind q.
Lanes MaskedFactors(const Vec3x4& x, const CouplingEnd& p, const CouplingEnd& q,
                    std::span<const Vec3> q_front) {
  const Lanes height = Dot(q.normal, x - q.polygon->v[0]);
  return Select(height > 0.0, PointFormFactors(x, p.normal, q_front), Splat(0.0));
}

double NearVariation(const CouplingEnd& p, const CouplingEnd& q, std::span<const Vec3> q_front,
                     double mean, bool closest) {
  Range range;
  range.Add(MaskedFactors(CornerSamples(p), p, q, q_front));
  range.Add(Splat(mean));
  if (closest) {
    // To the centre of q and three of its corners; drawn in so that F stays defined.
    const auto& v = q.polygon->v;
    const Vec3x4 points = ClosestPoints(*p.polygon, p.normal, Vec3x4({q.centre, v[0], v[1], v[2]}));
    range.Add(MaskedFactors(Mix(p.centre, 0.05, points), p, q, q_front));
  }
  return range.Width();
}

}  // namespace

FormFactorVariation VariationOver(const CouplingEnd& p, const CouplingEnd& q, double coupling_m2) {
  const double tolerance_m = PlaneTolerance(p, q);
  const Facing q_facing = FacingOf(q, p, tolerance_m);
  const Facing p_facing = FacingOf(p, q, tolerance_m);
  if (q_facing == Facing::kBehind || p_facing == Facing::kBehind) return {};
  const double distance = glm::length(q.centre - p.centre);
  const double reach = p.radius_m + q.radius_m;
  const double kappa = distance > 0 ? reach / distance : std::numeric_limits<double>::infinity();
  if (q_facing == Facing::kFront && p_facing == Facing::kFront && kappa < kFarKappa &&
      2 * kappa * kappa * p.area_m2 * q.area_m2 / (kPi * distance * distance) <
          kFarTolerance * std::min(p.area_m2, q.area_m2)) {
    return {FarVariation(p, q), FarVariation(q, p)};
  }
  const ClippedPolygon q_front = ClipToFront(*q.polygon, p.polygon->v[0], p.normal, tolerance_m);
  const ClippedPolygon p_front = ClipToFront(*p.polygon, q.polygon->v[0], q.normal, tolerance_m);
  if (q_front.count == 0 || p_front.count == 0) return {};
  const bool closest = kappa > kClosestPointsKappa;
  return {NearVariation(p, q, q_front.corners(), coupling_m2 / p.area_m2, closest),
          NearVariation(q, p, p_front.corners(), coupling_m2 / q.area_m2, closest)};
}

}  // namespace isolux
