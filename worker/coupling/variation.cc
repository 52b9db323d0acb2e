#include "worker/coupling/variation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "worker/coupling/clip.h"
#include "worker/coupling/facing.h"
#include "worker/coupling/float_lanes.h"
#include "worker/coupling/lanes.h"

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
  FormFactorRange Least() const {
    const double least = std::min(std::min(low[0], low[1]), std::min(low[2], low[3]));
    const double most = std::max(std::max(high[0], high[1]), std::max(high[2], high[3]));
    return most > least ? FormFactorRange{least, most} : FormFactorRange{};
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

FormFactorRange FarRange(const CouplingEnd& p, const CouplingEnd& q) {
  Range range;
  range.Add(KernelFactors(CornerSamples(p), p.normal, q));
  return range.Least();
}

FloatLanes Narrow(Lanes low, Lanes high) {
  return reinterpret_cast<FloatLanes>(
      _mm256_set_m128(_mm256_cvtpd_ps(reinterpret_cast<__m256d>(high)),
                      _mm256_cvtpd_ps(reinterpret_cast<__m256d>(low))));
}

// Eight points in the plane of p, about its centre and in a unit of length that is a power of two,
// so that single precision serves at any place and scale.
class PlanePoints {
 public:
  PlanePoints(const CouplingEnd& p, double unit_m, const Vec3x4& first, const Vec3x4& second)
      : centre_(p.centre), normal_(p.normal), scale_(1 / unit_m) {
    const auto local = [&](const Lanes& a, const Lanes& b, double centre) {
      return Narrow(scale_ * (a - centre), scale_ * (b - centre));
    };
    x_ = local(first.x, second.x, centre_.x);
    y_ = local(first.y, second.y, centre_.y);
    z_ = local(first.z, second.z, centre_.z);
  }

  // Form factors to a polygon in front of the plane, as PointFormFactors; 0 from behind it.
  FloatLanes Factors(const CouplingEnd& q, std::span<const Vec3> q_front) const {
    FloatLanes sum{};
    for (size_t k = 0; k < q_front.size(); ++k) {
      const Vec3 corner = scale_ * (q_front[k] - centre_);
      const Vec3 side = scale_ * (q_front[(k + 1) % q_front.size()] - q_front[k]);
      const float sx = static_cast<float>(side.x), sy = static_cast<float>(side.y),
                  sz = static_cast<float>(side.z);
      const FloatLanes ax = static_cast<float>(corner.x) - x_;
      const FloatLanes ay = static_cast<float>(corner.y) - y_;
      const FloatLanes az = static_cast<float>(corner.z) - z_;
      const FloatLanes cx = ay * sz - az * sy, cy = az * sx - ax * sz, cz = ax * sy - ay * sx;
      const FloatLanes length = SquareRoot(cx * cx + cy * cy + cz * cz);
      const FloatLanes dot = ax * (ax + sx) + ay * (ay + sy) + az * (az + sz);
      const FloatLanes along = static_cast<float>(normal_.x) * cx +
                               static_cast<float>(normal_.y) * cy +
                               static_cast<float>(normal_.z) * cz;
      const FloatLanes term = Atan2Upper(length, dot) * along / Maximum(length, SplatFloat(1e-30F));
      sum -= Select(length > 1e-30F, term, FloatLanes{});
    }
    const Vec3 to = scale_ * (q.polygon->v[0] - centre_);
    const FloatLanes height =
        static_cast<float>(-glm::dot(q.normal, to)) + static_cast<float>(q.normal.x) * x_ +
        static_cast<float>(q.normal.y) * y_ + static_cast<float>(q.normal.z) * z_;
    const FloatLanes factor =
        Minimum(Maximum(sum * static_cast<float>(0.5 / kPi), FloatLanes{}), SplatFloat(1));
    return Select(height > 0.0F, factor, FloatLanes{});
  }

 private:
  Vec3 centre_, normal_;
  double scale_;
  FloatLanes x_{}, y_{}, z_{};
};

FormFactorRange NearRange(const CouplingEnd& p, const CouplingEnd& q, std::span<const Vec3> q_front,
                          bool closest, double unit_m) {
  const Vec3x4 corners = CornerSamples(p);
  Vec3x4 others = corners;
  if (closest) {
    // To the centre of q and three of its corners; drawn in so that F stays defined.
    const auto& v = q.polygon->v;
    const Vec3x4 points = ClosestPoints(*p.polygon, p.normal, Vec3x4({q.centre, v[0], v[1], v[2]}));
    others = Mix(p.centre, 0.05, points);
  }
  const FloatLanes factors = PlanePoints(p, unit_m, corners, others).Factors(q, q_front);
  float low = factors[0], high = low;
  for (int i = 1; i < 8; ++i) {
    low = std::min(low, factors[i]);
    high = std::max(high, factors[i]);
  }
  return {low, high};
}

// The corners of what `end` has in front of the other's plane; `part` holds them where that is not
// the whole.
std::span<const Vec3> FrontOf(const CouplingEnd& end, Facing facing, const CouplingEnd& other,
                              double tolerance_m, ClippedPolygon& part) {
  if (facing == Facing::kFront) {
    return {end.polygon->v.data(), static_cast<size_t>(end.polygon->count)};
  }
  part = ClipToFront(*end.polygon, other.polygon->v[0], other.normal, tolerance_m);
  return part.corners();
}

}  // namespace

FormFactorRanges RangesOver(const CouplingEnd& p, const CouplingEnd& q) {
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
    return {FarRange(p, q), FarRange(q, p)};
  }
  ClippedPolygon q_part, p_part;  // of those that the other's plane cuts
  const std::span<const Vec3> q_front = FrontOf(q, q_facing, p, tolerance_m, q_part);
  const std::span<const Vec3> p_front = FrontOf(p, p_facing, q, tolerance_m, p_part);
  if (q_front.empty() || p_front.empty()) return {};
  const bool closest = kappa > kClosestPointsKappa;
  const double unit_m = std::ldexp(1.0, std::ilogb(distance + reach));
  return {NearRange(p, q, q_front, closest, unit_m), NearRange(q, p, p_front, closest, unit_m)};
}

FormFactorVariation VariationWith(const FormFactorRanges& ranges, const CouplingEnd& p,
                                  const CouplingEnd& q, double coupling_m2) {
  return {ranges.over_p.WidthWith(coupling_m2 / p.area_m2),
          ranges.over_q.WidthWith(coupling_m2 / q.area_m2)};
}

}  // namespace isolux
