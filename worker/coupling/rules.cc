#include "worker/coupling/rules.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "worker/coupling/point_factor.h"

namespace isolux {
namespace {

constexpr double kPi = std::numbers::pi;

// Error of 3×3 points a pair of triangles: this times κ⁴ A_p A_q/(π d²).
constexpr double kKernelError = 6;
// Lambert's form is averaged over points where the other is farther than this many radii.
constexpr double kPointsReach = 0.7;
// Of the error estimates of the point rules; calibrated on random pairs.
constexpr double kStepShare = 0.5;
constexpr double kPoints3Error = 0.004;
constexpr double kPoints7Error = 0.0008;
constexpr double kRounding = 1e-13;

// Up to 21 points with weights that add up to the area, in groups of four; the rest of the last
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
  int groups() const { return (count_ + 3) / 4; }
  const Vec3x4& x(int group) const { return x_[group]; }
  const Lanes& weight(int group) const { return weight_[group]; }

 private:
  int count_ = 0;
  std::array<Vec3x4, 6> x_;
  std::array<Lanes, 6> weight_;
};

// Adds the points of a rule for triangles to each triangle of the fan. `add` takes the corners and
// the area.
template <typename AddTriangle>
void ForTriangles(const Shape& shape, const AddTriangle& add) {
  const Vec3& a = shape.corners[0];
  for (size_t i = 1; i + 1 < shape.corners.size(); ++i) {
    const Vec3& b = shape.corners[i];
    const Vec3& c = shape.corners[i + 1];
    add(a, b, c, 0.5 * glm::length(glm::cross(b - a, c - a)));
  }
}

// Degree 2.
WeightedPoints ThreeAPoints(const Shape& shape) {
  WeightedPoints points;
  ForTriangles(shape, [&](const Vec3& a, const Vec3& b, const Vec3& c, double area) {
    const Vec3 sum = a + b + c;
    for (const Vec3& corner : {a, b, c}) points.Add((sum + 3.0 * corner) / 6.0, area / 3);
  });
  return points;
}

// Degree 5 (Radon 1948).
WeightedPoints SevenAPoints(const Shape& shape) {
  constexpr double kNear = 0.10128650732345633;  // (6 − √15)/21
  constexpr double kFar = 0.47014206410511505;   // (6 + √15)/21
  constexpr double kNearWeight = 0.12593918054482717;
  constexpr double kFarWeight = 0.13239415278850616;
  WeightedPoints points;
  ForTriangles(shape, [&](const Vec3& a, const Vec3& b, const Vec3& c, double area) {
    const Vec3 sum = a + b + c;
    points.Add(sum / 3.0, 0.225 * area);
    for (const Vec3& corner : {a, b, c}) {
      points.Add(kNear * sum + (1 - 3 * kNear) * corner, kNearWeight * area);
      points.Add(kFar * sum + (1 - 3 * kFar) * corner, kFarWeight * area);
    }
  });
  return points;
}

// Σ w w' cosθ cosθ'/(π d²) over all points of both.
double KernelSum(const Shape& p, const Shape& q) {
  const WeightedPoints x = ThreeAPoints(p), y = ThreeAPoints(q);
  Lanes sum = Splat(0.0);
  for (int i = 0; i < x.groups(); ++i) {
    for (int lane = 0; lane < 4; ++lane) {
      const double weight = x.weight(i)[lane];
      if (weight == 0) continue;
      const Vec3 from(x.x(i).x[lane], x.x(i).y[lane], x.x(i).z[lane]);
      for (int j = 0; j < y.groups(); ++j) {
        const Vec3x4 d = y.x(j) - from;
        const Lanes d2 = Dot(d, d);
        const Lanes cosines =
            Maximum(Dot(p.normal, d), Splat(0.0)) * Maximum(-Dot(q.normal, d), Splat(0.0));
        sum += weight * y.weight(j) * cosines / (d2 * d2);
      }
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
  const double least = std::max({distance - p.radius - q.radius, LeastHeight(p, q)});
  if (!(least > kPointsReach * p.radius)) return false;
  const double ratio = p.radius / least;
  const double ratio2 = ratio * ratio;
  const double seen = q.radius / least;
  const double scale = p.area * std::min(1.0, seen * seen);
  // Whatever the steps between the rules turn out to be:
  if (kPoints7Error * ratio2 * ratio2 * ratio2 * scale > tolerance) return false;

  WeightedPoints centres;
  ForTriangles(p, [&](const Vec3& a, const Vec3& b, const Vec3& c, double area) {
    centres.Add((a + b + c) / 3.0, area);
  });
  const double coarse = PointSum(centres, p, q);
  const double middle = PointSum(ThreeAPoints(p), p, q);
  double error = kStepShare * std::abs(middle - coarse) * ratio2 +
                 kPoints3Error * ratio2 * ratio2 * scale + kRounding * middle;
  if (error <= tolerance) {
    result = {middle, error, Regime::kPoints3};
    return true;
  }
  const double fine = PointSum(SevenAPoints(p), p, q);
  error = kStepShare * std::abs(fine - middle) * ratio2 +
          kPoints7Error * ratio2 * ratio2 * ratio2 * scale + kRounding * fine;
  if (error > tolerance) return false;
  result = {fine, error, Regime::kPoints7};
  return true;
}

}  // namespace isolux
