#include "worker/coupling/variation.h"

#include <algorithm>
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
std::array<Vec3, 4> CornerSamples(const CouplingEnd& end) {
  std::array<Vec3, 4> points;
  for (int i = 0; i < 4; ++i) {
    points[i] = i < end.polygon->count ? Lerp(end.polygon->v[i], end.centre, 0.1) : end.centre;
  }
  return points;
}

// The point of a convex polygon closest to x.
Vec3 ClosestPoint(const ConvexPolygon& polygon, const Vec3& normal, const Vec3& x) {
  bool inside = true;
  double best = std::numeric_limits<double>::infinity();
  Vec3 closest = polygon.v[0];
  for (int i = 0; i < polygon.count; ++i) {
    const Vec3& a = polygon.v[i];
    const Vec3 side = polygon.v[(i + 1) % polygon.count] - a;
    if (glm::dot(glm::cross(normal, side), x - a) < 0) inside = false;
    const double length2 = glm::dot(side, side);
    const double t = length2 > 0 ? std::clamp(glm::dot(x - a, side) / length2, 0.0, 1.0) : 0.0;
    const Vec3 candidate = a + t * side;
    const double distance2 = glm::dot(x - candidate, x - candidate);
    if (distance2 < best) {
      best = distance2;
      closest = candidate;
    }
  }
  return inside ? x - glm::dot(normal, x - polygon.v[0]) * normal : closest;
}

// Range of a set of lanes, widened lane by lane.
struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = 0;
  void Add(const Lanes& values) {
    for (int i = 0; i < 4; ++i) {
      low = std::min(low, values[i]);
      high = std::max(high, values[i]);
    }
  }
  double Width() const { return high > low ? high - low : 0.0; }
};

// Kernel cosθ cosθ'/(π d²) times the area of the source, from four points to one.
Lanes KernelFactors(const std::array<Vec3, 4>& points, const Vec3& n, const CouplingEnd& source) {
  const Vec3x4 d = source.centre - Vec3x4(points);
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
Lanes MaskedFactors(const std::array<Vec3, 4>& points, const CouplingEnd& p, const CouplingEnd& q,
                    std::span<const Vec3> q_front) {
  const Vec3x4 x(points);
  const Lanes height = Dot(q.normal, x - q.polygon->v[0]);
  return Select(height > 0.0, PointFormFactors(x, p.normal, q_front), Splat(0.0));
}

double NearVariation(const CouplingEnd& p, const CouplingEnd& q, std::span<const Vec3> q_front,
                     double mean, bool closest) {
  Range range;
  range.Add(MaskedFactors(CornerSamples(p), p, q, q_front));
  range.Add(Splat(mean));
  if (closest) {
    std::array<Vec3, 4> points;
    for (int i = 0; i < 4; ++i) {
      // The centre of q first, then three of its corners; drawn in so that F stays defined.
      const Vec3 target = i == 0 ? q.centre : q.polygon->v[i - 1];
      points[i] = Lerp(ClosestPoint(*p.polygon, p.normal, target), p.centre, 0.05);
    }
    range.Add(MaskedFactors(points, p, q, q_front));
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
