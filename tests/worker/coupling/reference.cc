#include "tests/worker/coupling/reference.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <numbers>
#include <vector>

namespace isolux::testing {
namespace {

using Real = long double;
using Point = glm::vec<3, Real>;
using Corners = std::vector<Point>;

constexpr Real kPi = std::numbers::pi_v<Real>;

Corners CornersOf(const ConvexPolygon& polygon, const Point& origin) {
  Corners corners;
  for (int i = 0; i < polygon.count; ++i) corners.push_back(Point(polygon.v[i]) - origin);
  return corners;
}

Point AreaVector(const Corners& corners) {
  Point sum(0);
  for (size_t i = 1; i + 1 < corners.size(); ++i) {
    sum += glm::cross(corners[i] - corners[0], corners[i + 1] - corners[0]);
  }
  return sum / Real(2);
}

Corners InFront(const Corners& corners, const Corners& plane) {
  const Point n = glm::normalize(AreaVector(plane));
  Corners result;
  for (size_t i = 0; i < corners.size(); ++i) {
    const Point &a = corners[i], &b = corners[(i + 1) % corners.size()];
    const Real height_a = glm::dot(n, a - plane[0]), height_b = glm::dot(n, b - plane[0]);
    if (height_a >= 0) result.push_back(a);
    if ((height_a > 0 && height_b < 0) || (height_a < 0 && height_b > 0)) {
      result.push_back(a + height_a / (height_a - height_b) * (b - a));
    }
  }
  return result;
}

struct Side {
  Point start, along;
  Real length;
};
std::vector<Side> SidesOf(const Corners& corners) {
  std::vector<Side> sides;
  for (size_t i = 0; i < corners.size(); ++i) {
    const Point d = corners[(i + 1) % corners.size()] - corners[i];
    const Real length = glm::length(d);
    if (length > 0) sides.push_back({corners[i], d / length, length});
  }
  return sides;
}

// ∫_f ln|x − y| dy.
Real Potential(const Point& x, const Side& f) {
  const Point to = f.start - x;
  const Real a = glm::dot(to, f.along), b = a + f.length;
  const Real g = glm::length(glm::cross(to, f.along));
  const auto x_log_r = [g](Real t) {
    const Real r = std::hypot(t, g);
    return r > 0 ? t * std::log(r) : Real(0);
  };
  return x_log_r(b) - x_log_r(a) - f.length + g * std::atan2(g * f.length, g * g + a * b);
}

// Points and weights on (0, 1), and how far from the nearer end, at a step of 2^-level.
Real TanhSinh(const Side& e, const Side& f, Real from, Real to) {
  const Real half = (to - from) / 2;
  const auto at = [&](Real t) {
    const Real u = kPi / 2 * std::sinh(t);
    const Real weight = kPi / 2 * std::cosh(t) / (std::cosh(u) * std::cosh(u));
    const Real from_end = half / (std::exp(std::abs(u)) * std::cosh(u));  // half·(1 − |tanh u|)
    const Real s = t < 0 ? from + from_end : to - from_end;
    return weight * Potential(e.start + s * e.along, f);
  };
  constexpr Real kReach = 4.2L;
  Real step = 0.5L;
  Real sum = at(0);
  for (Real t = step; t < kReach; t += step) sum += at(t) + at(-t);
  Real value = sum * step * half;
  for (int level = 0; level < 6; ++level) {
    Real more = 0;
    for (Real t = step / 2; t < kReach; t += step) more += at(t) + at(-t);
    sum += more;
    step /= 2;
    const Real finer = sum * step * half;
    const bool converged = std::abs(finer - value) < 1e-15L * (std::abs(finer) + half * f.length);
    value = finer;
    if (converged && level > 0) break;
  }
  return value;
}

Real AlongSide(const Side& e, const Side& f) {
  std::vector<Real> cuts = {0, e.length};
  for (const Point& end : {f.start, f.start + f.length * f.along}) {
    cuts.push_back(glm::dot(end - e.start, e.along));
  }
  const Point turn = glm::cross(e.along, f.along);
  if (glm::dot(turn, turn) > 1e-30L) {
    cuts.push_back(glm::dot(glm::cross(f.start - e.start, f.along), turn) / glm::dot(turn, turn));
  }
  std::erase_if(cuts, [&](Real s) { return s < 0 || s > e.length; });
  std::sort(cuts.begin(), cuts.end());
  Real sum = 0;
  for (size_t i = 0; i + 1 < cuts.size(); ++i) {
    if (cuts[i + 1] > cuts[i]) sum += TanhSinh(e, f, cuts[i], cuts[i + 1]);
  }
  return sum;
}

Real PointFactor(const Point& x, const Point& n, const Corners& q) {
  Real sum = 0;
  for (size_t k = 0; k < q.size(); ++k) {
    const Point a = q[k] - x, b = q[(k + 1) % q.size()] - x;
    const Point cross = glm::cross(a, b);
    const Real length = glm::length(cross);
    if (length > 0) sum -= std::atan2(length, glm::dot(a, b)) * glm::dot(n, cross) / length;
  }
  return std::clamp(sum / (2 * kPi), Real(0), Real(1));
}

// Over a triangle, by Radon's seven points; divided into four.
Real OverTriangle(const Point& a, const Point& b, const Point& c, const Point& n, const Corners& q,
                  Real tolerance, int depth) {
  const auto rule = [&](const Point& u, const Point& v, const Point& w) {
    const Real root = std::sqrt(Real(15));
    const Real near = (6 - root) / 21, far = (6 + root) / 21;
    const Point sum = u + v + w;
    Real value = Real(9) / 40 * PointFactor(sum / Real(3), n, q);
    for (const Point& corner : {u, v, w}) {
      value += (155 - root) / 1200 * PointFactor(near * sum + (1 - 3 * near) * corner, n, q);
      value += (155 + root) / 1200 * PointFactor(far * sum + (1 - 3 * far) * corner, n, q);
    }
    return value * glm::length(glm::cross(v - u, w - u)) / 2;
  };
  const Point ab = (a + b) / Real(2), bc = (b + c) / Real(2), ca = (c + a) / Real(2);
  const Real whole = rule(a, b, c);
  const Real parts = rule(a, ab, ca) + rule(ab, b, bc) + rule(ca, bc, c) + rule(ab, bc, ca);
  if (std::abs(parts - whole) < tolerance || depth == 12) return parts;
  return OverTriangle(a, ab, ca, n, q, tolerance / 2, depth + 1) +
         OverTriangle(ab, b, bc, n, q, tolerance / 2, depth + 1) +
         OverTriangle(ca, bc, c, n, q, tolerance / 2, depth + 1) +
         OverTriangle(ab, bc, ca, n, q, tolerance / 2, depth + 1);
}

}  // namespace

long double CouplingByContours(const ConvexPolygon& p, const ConvexPolygon& q) {
  const Point origin((Point(p.v[0]) + Point(q.v[0])) / Real(2));
  const Corners whole_p = CornersOf(p, origin), whole_q = CornersOf(q, origin);
  Corners part_p = InFront(whole_p, whole_q), part_q = InFront(whole_q, whole_p);
  if (part_p.size() < 3 || part_q.size() < 3) return 0;
  if (glm::length(AreaVector(part_p)) > glm::length(AreaVector(part_q))) part_p.swap(part_q);
  Real sum = 0;
  for (const Side& e : SidesOf(part_p)) {
    for (const Side& f : SidesOf(part_q)) sum += glm::dot(e.along, f.along) * AlongSide(e, f);
  }
  return sum / (2 * kPi);
}

long double CouplingByPoints(const ConvexPolygon& p, const ConvexPolygon& q,
                             long double tolerance) {
  const Corners corners_p = CornersOf(p, Point(p.v[0])), corners_q = CornersOf(q, Point(p.v[0]));
  const Point n = glm::normalize(AreaVector(corners_p));
  Real sum = 0;
  for (size_t i = 1; i + 1 < corners_p.size(); ++i) {
    sum += OverTriangle(corners_p[0], corners_p[i], corners_p[i + 1], n, corners_q, tolerance, 0);
  }
  return sum;
}

}  // namespace isolux::testing
