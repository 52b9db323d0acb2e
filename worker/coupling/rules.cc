#include "worker/coupling/rules.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "worker/coupling/point_factor.h"

namespace isolux {
namespace {

constexpr double kPi = std::numbers::pi;

// Error of the few points of both polygons: this times κ⁴ A_p A_q/(π d²).
constexpr double kKernelError = 6;
// Lambert's form is averaged over points where the other is farther than this many radii.
constexpr double kPointsReach = 0.7;
// Errors of the point rules, with x the smaller's radius over the distance and A its area (less
// where the larger looks small): a x³/(1 + x²) A of the few, b x⁵/(1 + x²) A of the many. The
// largest seen on random pairs, a little enlarged; triangles are better off.
struct PointErrors {
  double few, many;
};
constexpr PointErrors kTriangleErrors{0.009, 0.0015};
constexpr PointErrors kQuadErrors{0.028, 0.0095};
constexpr double kRounding = 1e-13;

// Up to 16 points with weights that add up to the area, in groups of four; the rest of the last
// group has weight 0.
class WeightedPoints {
 public:
  void Add(const Vec3& x, double weight) {
    const int lane = count_ % 4;
    if (lane == 0) {  // the others of the group until they are given
      x_[count_ / 4] = {Splat(x.x), Splat(x.y), Splat(x.z)};
      weight_[count_ / 4] = Splat(0.0);
    }
    Vec3x4& group = x_[count_ / 4];
    group.x[lane] = x.x;
    group.y[lane] = x.y;
    group.z[lane] = x.z;
    weight_[count_ / 4][lane] = weight;
    ++count_;
  }
  int count() const { return count_; }
  int groups() const { return (count_ + 3) / 4; }
  const Vec3x4& x(int group) const { return x_[group]; }
  const Lanes& weight(int group) const { return weight_[group]; }

 private:
  int count_ = 0;
  std::array<Vec3x4, 4> x_;
  std::array<Lanes, 4> weight_;
};

// Gauss's rule in both directions of the bilinear map of a quad. `gauss`: place and weight on [0,
// 1].
template <size_t N>
void AddQuad(std::span<const Vec3> v, const std::array<std::pair<double, double>, N>& gauss,
             WeightedPoints& points) {
  // By differences of corners: they are exact however small the quad is.
  const Vec3 first = v[1] - v[0], opposite = v[2] - v[3], side = v[3] - v[0];
  for (const auto& [s, weight_s] : gauss) {
    const Vec3 low = v[0] + s * first;
    const Vec3 across = side + s * (opposite - first);
    for (const auto& [t, weight_t] : gauss) {
      const Vec3 along = (1 - t) * first + t * opposite;
      points.Add(low + t * across, weight_s * weight_t * glm::length(glm::cross(along, across)));
    }
  }
}

// Degree 2 on triangles, 3 on parallelograms: three or four points.
WeightedPoints FewPoints(const Shape& shape) {
  constexpr double kGauss = 0.21132486540518712;  // (1 − 1/√3)/2
  constexpr std::array<std::pair<double, double>, 2> kTwo{{{kGauss, 0.5}, {1 - kGauss, 0.5}}};
  WeightedPoints points;
  const std::span<const Vec3> v = shape.corners;
  if (v.size() > 3) AddQuad(v, kTwo, points);
  if (v.size() != 4) {
    const Vec3 &a = v[0], &b = v[v.size() - 2], &c = v[v.size() - 1];
    const Vec3 sum = a + b + c;
    const double third = glm::length(glm::cross(b - a, c - a)) / 6;
    for (const Vec3& corner : {a, b, c}) points.Add((sum + 3.0 * corner) / 6.0, third);
  }
  return points;
}

// Degree 5: seven points on triangles ([Radon48]), nine on quads.
WeightedPoints ManyPoints(const Shape& shape) {
  constexpr double kGauss = 0.1127016653792583;  // (1 − √(3/5))/2
  constexpr std::array<std::pair<double, double>, 3> kThree{
      {{kGauss, 5.0 / 18}, {0.5, 8.0 / 18}, {1 - kGauss, 5.0 / 18}}};
  constexpr double kNear = 0.10128650732345633;  // (6 − √15)/21
  constexpr double kFar = 0.47014206410511505;   // (6 + √15)/21
  constexpr double kNearWeight = 0.12593918054482717;
  constexpr double kFarWeight = 0.13239415278850616;
  WeightedPoints points;
  const std::span<const Vec3> v = shape.corners;
  if (v.size() > 3) AddQuad(v, kThree, points);
  if (v.size() != 4) {
    const Vec3 &a = v[0], &b = v[v.size() - 2], &c = v[v.size() - 1];
    const Vec3 sum = a + b + c;
    const double area = 0.5 * glm::length(glm::cross(b - a, c - a));
    points.Add(sum / 3.0, 0.225 * area);
    for (const Vec3& corner : {a, b, c}) {
      points.Add(kNear * sum + (1 - 3 * kNear) * corner, kNearWeight * area);
      points.Add(kFar * sum + (1 - 3 * kFar) * corner, kFarWeight * area);
    }
  }
  return points;
}

// Σ w w' cosθ cosθ'/(π d²) over all points of both.
double KernelSum(const Shape& p, const Shape& q) {
  const WeightedPoints x = FewPoints(p), y = FewPoints(q);
  Lanes sum = Splat(0.0);
  for (int i = 0; i < x.count(); ++i) {
    const Vec3x4& group = x.x(i / 4);
    const Vec3 from(group.x[i % 4], group.y[i % 4], group.z[i % 4]);
    const double weight = x.weight(i / 4)[i % 4];
    for (int j = 0; j < y.groups(); ++j) {
      const Vec3x4 d = y.x(j) - from;
      const Lanes d2 = Dot(d, d);
      const Lanes cosines =
          Maximum(Dot(p.normal, d), Splat(0.0)) * Maximum(-Dot(q.normal, d), Splat(0.0));
      sum += weight * y.weight(j) * cosines / (d2 * d2);
    }
  }
  return Total(sum) / kPi;
}

// ∫ F dA by these points.
double PointSum(const WeightedPoints& points, const Shape& p, const Shape& q) {
  Lanes sum = Splat(0.0);
  for (int i = 0; i < points.groups(); ++i) {
    sum += points.weight(i) * PointFormFactors(points.x(i), p.normal, q.corners);
  }
  return Total(sum);
}

// How far the corners of `shape` are above the plane of `other` at least.
double LeastHeight(const Shape& shape, const Shape& other) {
  double least = std::numeric_limits<double>::infinity();
  for (const Vec3& v : shape.corners) {
    least = std::min(least, glm::dot(other.normal, v - other.corners[0]));
  }
  return least;
}

}  // namespace

bool TryKernelRules(const Shape& p, const Shape& q, double tolerance, PairCoupling& result) {
  const Vec3 d = q.centre - p.centre;
  const double d2 = glm::dot(d, d);
  const double reach = p.radius + q.radius;
  const double kappa2 = reach * reach / d2;
  if (!(kappa2 < kNegligibleKappa * kNegligibleKappa)) return false;
  const double even = p.area * q.area / (kPi * d2);
  const double bound = std::min({p.area, q.area, even});
  const auto midpoint = [&] {
    const double cosines =
        std::max(0.0, glm::dot(p.normal, d)) * std::max(0.0, -glm::dot(q.normal, d));
    return std::min(even * cosines / d2, bound);
  };
  if (bound <= tolerance) {
    result = {midpoint(), bound, Regime::kNegligible};
    return true;
  }
  if (!(kappa2 < kKernelKappa * kKernelKappa)) return false;
  if (const double error = kMidpointError * kappa2 * even; error <= tolerance) {
    result = {midpoint(), error, Regime::kMidpoint};
    return true;
  }
  if (const double error = kKernelError * kappa2 * kappa2 * even; error <= tolerance) {
    result = {std::min(KernelSum(p, q), bound), error, Regime::kKernel};
    return true;
  }
  return false;
}

bool TryPointRules(const Shape& p, const Shape& q, double tolerance, PairCoupling& result) {
  const double distance = glm::length(q.centre - p.centre);
  const double least = std::max(distance - p.radius - q.radius, LeastHeight(p, q));
  if (!(least > kPointsReach * p.radius)) return false;
  const double ratio = p.radius / least, ratio2 = ratio * ratio;
  const double seen = q.radius / least;
  const double scale = ratio * ratio2 / (1 + ratio2) * p.area * std::min(1.0, seen * seen);
  const PointErrors& errors = p.corners.size() == 3 ? kTriangleErrors : kQuadErrors;
  const auto decide = [&](double error, const auto& points, Regime regime) {
    if (error > tolerance) return false;
    const double value = PointSum(points(p), p, q);
    result = {value, error + kRounding * value, regime};
    return true;
  };
  return decide(errors.few * scale, FewPoints, Regime::kPoints) ||
         decide(errors.many * ratio2 * scale, ManyPoints, Regime::kManyPoints);
}

}  // namespace isolux
