#include "worker/radiosity/coupling.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/hierarchy/element.h"

namespace isolux {
namespace {

constexpr double kPi = std::numbers::pi;

// Below this (radii over distance) polygons are taken as points: the centroid rule is within 2κ² of
// C, and is used where that is below kFarTolerance of the smaller area.
constexpr double kFarKappa = 0.2;
constexpr double kFarTolerance = 1e-3;
// Nearer than this many radii of the smaller end, four points are not enough: sixteen are taken.
constexpr double kNearRadii = 2.0;
// Ends whose radii together exceed this share of their distance can have most of their exchange
// near one point, which corner samples miss: the closest points are sampled too.
constexpr double kClosestPointsKappa = 0.7;

// Which side of the plane of `end` a polygon is on.
enum class Facing { kBehind, kFront, kCut };
Facing FacingOf(const ConvexPolygon& polygon, const CouplingEnd& end, double tolerance) {
  bool front = false, behind = false;
  for (int i = 0; i < polygon.count; ++i) {
    const double height = glm::dot(end.normal, polygon.v[i] - end.polygon->v[0]);
    front |= height > tolerance;
    behind |= height < -tolerance;
  }
  return !front ? Facing::kBehind : behind ? Facing::kCut : Facing::kFront;
}

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

// F from points in the plane of p to q (already in front of that plane); 0 for points behind q.
Lanes MaskedFactors(const std::array<Vec3, 4>& points, const CouplingEnd& p, const CouplingEnd& q,
                    std::span<const Vec3> q_front) {
  const Vec3x4 x(points);
  const Lanes height = Dot(q.normal, x - q.polygon->v[0]);
  return Select(height > 0.0, PointFormFactors(x, p.normal, q_front), Splat(0.0));
}

double VariationOver(const CouplingEnd& p, const CouplingEnd& q, std::span<const Vec3> q_front,
                     double mean, bool near) {
  Range range;
  range.Add(MaskedFactors(CornerSamples(p), p, q, q_front));
  range.Add(Splat(mean));
  if (near) {
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

// Kernel cosθ cosθ'/(π d²) times the area of the source, from four points to one.
Lanes KernelFactors(const std::array<Vec3, 4>& points, const Vec3& n, const CouplingEnd& source) {
  const Vec3x4 d = source.centre - Vec3x4(points);
  const Lanes d2 = Dot(d, d);
  const Lanes cosines =
      Maximum(Dot(n, d), Splat(0.0)) * Maximum(-Dot(source.normal, d), Splat(0.0));
  return cosines * source.area_m2 / (kPi * d2 * d2);
}

PolygonCoupling CoupleFar(const CouplingEnd& p, const CouplingEnd& q, double kappa) {
  const Vec3 d = q.centre - p.centre;
  const double d2 = glm::dot(d, d);
  const double cosines =
      std::max(0.0, glm::dot(p.normal, d)) * std::max(0.0, -glm::dot(q.normal, d));
  PolygonCoupling result;
  result.coupling_m2 = p.area_m2 * q.area_m2 * cosines / (kPi * d2 * d2);
  result.error_m2 = 2 * kappa * kappa * p.area_m2 * q.area_m2 / (kPi * d2);
  Range over_p, over_q;
  over_p.Add(KernelFactors(CornerSamples(p), p.normal, q));
  over_q.Add(KernelFactors(CornerSamples(q), q.normal, p));
  result.variation_p = over_p.Width();
  result.variation_q = over_q.Width();
  return result;
}

// ∫ F(x→q) dA over a convex polygon, 2×2 Gauss points for a quad's bilinear map, three points for a
// triangle.
double IntegrateOver(const ConvexPolygon& part, const CouplingEnd& p, const CouplingEnd& q,
                     std::span<const Vec3> q_front) {
  std::array<Vec3, 4> points;
  std::array<double, 4> weight{};
  if (part.count == 3) {
    const double third = part.Area() / 3;
    for (int i = 0; i < 3; ++i) {
      points[i] = (4.0 * part.v[i] + part.v[(i + 1) % 3] + part.v[(i + 2) % 3]) / 6.0;
      weight[i] = third;
    }
    points[3] = points[0];
  } else {
    constexpr double kGauss = 0.21132486540518712;  // (1 − 1/√3)/2
    for (int i = 0; i < 4; ++i) {
      const double s = (i & 1) != 0 ? 1 - kGauss : kGauss;
      const double t = (i & 2) != 0 ? 1 - kGauss : kGauss;
      const Vec3 low = Lerp(part.v[0], part.v[1], s);
      const Vec3 high = Lerp(part.v[3], part.v[2], s);
      points[i] = Lerp(low, high, t);
      const Vec3 along_s = Lerp(part.v[1] - part.v[0], part.v[2] - part.v[3], t);
      weight[i] = 0.25 * glm::length(glm::cross(along_s, high - low));
    }
  }
  const Lanes factors = MaskedFactors(points, p, q, q_front);
  return factors[0] * weight[0] + factors[1] * weight[1] + factors[2] * weight[2] +
         factors[3] * weight[3];
}

double IntegrateDivided(const ConvexPolygon& part, int levels, const CouplingEnd& p,
                        const CouplingEnd& q, std::span<const Vec3> q_front) {
  if (levels == 0) return IntegrateOver(part, p, q, q_front);
  const auto children = Subdivide(part);
  return IntegrateDivided(children[0], levels - 1, p, q, q_front) +
         IntegrateDivided(children[1], levels - 1, p, q, q_front);
}

// The clipped polygon as at most three convex parts with three or four corners.
std::array<ConvexPolygon, 2> Parts(const ClippedPolygon& polygon) {
  std::array<ConvexPolygon, 2> parts;
  parts[0].count = std::min(polygon.count, 4);
  for (int i = 0; i < parts[0].count; ++i) parts[0].v[i] = polygon.v[i];
  if (polygon.count == 5) parts[1] = {3, {polygon.v[0], polygon.v[3], polygon.v[4]}};
  return parts;
}

}  // namespace

double ClippedPolygon::Area() const {
  Vec3 sum(0.0);
  for (int i = 1; i + 1 < count; ++i) sum += glm::cross(v[i] - v[0], v[i + 1] - v[0]);
  return 0.5 * glm::length(sum);
}

ClippedPolygon ClipToFront(const ConvexPolygon& polygon, const Vec3& point, const Vec3& normal,
                           double tolerance_m) {
  std::array<double, 4> height{};
  for (int i = 0; i < polygon.count; ++i) {
    height[i] = glm::dot(normal, polygon.v[i] - point);
    if (std::abs(height[i]) <= tolerance_m) height[i] = 0;
  }
  ClippedPolygon result;
  bool front = false;
  for (int i = 0; i < polygon.count; ++i) {
    const int j = (i + 1) % polygon.count;
    front |= height[i] > 0;
    if (height[i] >= 0 && result.count < 5) result.v[result.count++] = polygon.v[i];
    if (height[i] * height[j] < 0 && result.count < 5) {
      result.v[result.count++] =
          Lerp(polygon.v[i], polygon.v[j], height[i] / (height[i] - height[j]));
    }
  }
  if (!front || result.count < 3) result.count = 0;
  return result;
}

Lanes PointFormFactors(const Vec3x4& points, const Vec3& n, std::span<const Vec3> q) {
  Lanes sum = Splat(0.0);
  const Vec3x4 first = q[0] - points;
  Vec3x4 a = first;
  for (size_t k = 0; k < q.size(); ++k) {
    const Vec3x4 b = k + 1 < q.size() ? q[k + 1] - points : first;
    const Vec3x4 cross = Cross(a, b);
    const Lanes length = SquareRoot(Dot(cross, cross));
    const Lanes angle = Atan2Upper(length, Dot(a, b));
    const Lanes term = angle * Dot(n, cross) / Select(length == 0.0, Splat(1.0), length);
    sum -= Select(length == 0.0, Splat(0.0), term);
    a = b;
  }
  return Minimum(Maximum(sum * (0.5 / kPi), Splat(0.0)), Splat(1.0));
}

CouplingEnd MakeCouplingEnd(const ConvexPolygon& polygon) {
  CouplingEnd end;
  end.polygon = &polygon;
  const Vec3 area = polygon.AreaVector();
  end.area_m2 = glm::length(area);
  end.normal = end.area_m2 > 0 ? area / end.area_m2 : Vec3(0.0, 0.0, 1.0);
  end.centre = polygon.Centroid();
  for (int i = 0; i < polygon.count; ++i) {
    end.radius_m = std::max(end.radius_m, glm::length(polygon.v[i] - end.centre));
  }
  return end;
}

PolygonCoupling Couple(const CouplingEnd& p, const CouplingEnd& q) {
  const double distance = glm::length(q.centre - p.centre);
  const double reach = p.radius_m + q.radius_m;
  const double tolerance = 1e-12 * (distance + reach);
  const Facing q_facing = FacingOf(*q.polygon, p, tolerance);
  const Facing p_facing = FacingOf(*p.polygon, q, tolerance);
  if (q_facing == Facing::kBehind || p_facing == Facing::kBehind) return {};

  const double smaller = std::min(p.area_m2, q.area_m2);
  const double kappa = distance > 0 ? reach / distance : std::numeric_limits<double>::infinity();
  const bool cut = q_facing == Facing::kCut || p_facing == Facing::kCut;
  if (!cut && kappa < kFarKappa) {
    const PolygonCoupling far = CoupleFar(p, q, kappa);
    if (far.error_m2 < kFarTolerance * smaller) return far;
  }

  // The part of each in front of the other's plane.
  const ClippedPolygon q_front = ClipToFront(*q.polygon, p.polygon->v[0], p.normal, tolerance);
  const ClippedPolygon p_front = ClipToFront(*p.polygon, q.polygon->v[0], q.normal, tolerance);
  if (q_front.count == 0 || p_front.count == 0) return {};
  const std::span<const Vec3> q_corners(q_front.v.data(), q_front.count);
  const std::span<const Vec3> p_corners(p_front.v.data(), p_front.count);

  // Quadrature runs over the smaller polygon, Lambert's form over the larger.
  const bool over_p = p.area_m2 <= q.area_m2;
  const CouplingEnd& outer = over_p ? p : q;
  const CouplingEnd& inner = over_p ? q : p;
  const bool near = distance - inner.radius_m < kNearRadii * outer.radius_m;
  double coarse = 0, fine = 0;
  for (const ConvexPolygon& part : Parts(over_p ? p_front : q_front)) {
    if (part.count == 0) continue;
    const auto corners = over_p ? q_corners : p_corners;
    coarse += IntegrateOver(part, outer, inner, corners);
    if (near) fine += IntegrateDivided(part, 2, outer, inner, corners);
  }
  PolygonCoupling result;
  result.coupling_m2 = std::clamp(near ? fine : coarse, 0.0, smaller);
  result.error_m2 = near ? std::abs(fine - coarse) : 0.01 * kappa * kappa * coarse;
  result.error_m2 = std::min(result.error_m2, smaller);
  const bool closest = kappa > kClosestPointsKappa;
  result.variation_p = VariationOver(p, q, q_corners, result.coupling_m2 / p.area_m2, closest);
  result.variation_q = VariationOver(q, p, p_corners, result.coupling_m2 / q.area_m2, closest);
  return result;
}

}  // namespace isolux
