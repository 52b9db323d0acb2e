// Random convex polygons and other shapes for tests of visibility and couplings.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "common/scene/scene.h"
#include "common/util/random.h"

namespace isolux::testing {

inline Vec3 RandomPoint(Random& random, const Vec3& low, const Vec3& high) {
  const double x = random.Unit(), y = random.Unit(), z = random.Unit();
  return low + Vec3(x, y, z) * (high - low);
}

// Unit vector, evenly distributed.
inline Vec3 RandomDirection(Random& random) {
  const double z = 2 * random.Unit() - 1, angle = 2 * std::numbers::pi * random.Unit();
  const double r = std::sqrt(std::max(0.0, 1 - z * z));
  return {r * std::cos(angle), r * std::sin(angle), z};
}

// Corners on an ellipse in a random plane: convex, counter-clockwise about the plane's normal.
inline std::vector<Vec3> RandomConvexPolygon(Random& random, const Vec3& centre, double radius,
                                             int corners) {
  const Vec3 normal = RandomDirection(random);
  const Vec3 helper = std::abs(normal.x) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
  const Vec3 u = glm::normalize(glm::cross(helper, normal)), v = glm::cross(normal, u);
  std::vector<double> angles;
  angles.reserve(static_cast<size_t>(corners));
  for (int i = 0; i < corners; ++i) {
    angles.push_back(2 * std::numbers::pi * (i + 0.8 * random.Unit()) / corners);
  }
  const double flat = 0.3 + 0.7 * random.Unit();
  std::vector<Vec3> result;
  result.reserve(angles.size());
  for (const double angle : angles) {
    result.push_back(centre + radius * (std::cos(angle) * u + flat * std::sin(angle) * v));
  }
  return result;
}

inline ConvexPolygon ToPolygon(const std::vector<Vec3>& corners) {
  ConvexPolygon polygon;
  polygon.count = static_cast<int>(corners.size());
  std::copy(corners.begin(), corners.end(), polygon.v.begin());
  return polygon;
}

// A rectangle with two sides along axes other than `axis`, at `at` on it; `up`: its front looks
// that way along the axis.
inline ConvexPolygon AxisRectangle(int axis, double at, double u0, double u1, double v0, double v1,
                                   bool up) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  ConvexPolygon polygon;
  polygon.count = 4;
  const double us[] = {u0, u1, u1, u0}, vs[] = {v0, v0, v1, v1};
  for (int i = 0; i < 4; ++i) {
    Vec3& corner = polygon.v[up ? i : 3 - i];
    corner[axis] = at;
    corner[u] = us[i];
    corner[v] = vs[i];
  }
  return polygon;
}

// Corners on a lattice of quarters, so that ends and occluders share planes, edges and corners.
inline ConvexPolygon LatticePolygon(Random& random) {
  const auto at = [&] { return 0.25 * static_cast<double>(random.Bits() % 5); };
  for (;;) {
    const bool up = random.Unit() < 0.5, cut = random.Unit() < 0.4;
    const double u0 = at(), u1 = at(), v0 = at(), v1 = at();
    if (!(u0 < u1 && v0 < v1)) continue;
    ConvexPolygon polygon =
        AxisRectangle(static_cast<int>(random.Bits() % 3), at(), u0, u1, v0, v1, up);
    if (cut) polygon.count = 3;
    return polygon;
  }
}

inline std::span<const Vec3> CornersOf(const ConvexPolygon& polygon) {
  return {polygon.v.data(), static_cast<size_t>(polygon.count)};
}

// A direction above a plane, by its cosine.
inline Vec3 CosineDirection(const Vec3& normal, Random& random) {
  for (;;) {
    const Vec3 d = normal + RandomDirection(random);
    if (glm::length(d) > 1e-6) return glm::normalize(d);
  }
}

// Whether a point of the polygon's plane lies in it.
inline bool Contains(const ConvexPolygon& polygon, const Vec3& x) {
  const Vec3 n = polygon.Normal();
  for (int i = 0; i < polygon.count; ++i) {
    const Vec3 edge = polygon.v[(i + 1) % polygon.count] - polygon.v[i];
    if (glm::dot(glm::cross(edge, x - polygon.v[i]), n) < 0) return false;
  }
  return true;
}

// A uniform point of a convex polygon.
inline Vec3 PointOn(std::span<const Vec3> corners, Random& random) {
  double total = 0;
  for (size_t i = 2; i < corners.size(); ++i) {
    total += glm::length(glm::cross(corners[i - 1] - corners[0], corners[i] - corners[0]));
  }
  double target = random.Unit() * total;
  size_t i = 2;
  for (; i + 1 < corners.size(); ++i) {
    target -= glm::length(glm::cross(corners[i - 1] - corners[0], corners[i] - corners[0]));
    if (target < 0) break;
  }
  const double s = std::sqrt(random.Unit()), t = random.Unit();
  return corners[0] + s * ((1 - t) * (corners[i - 1] - corners[0]) + t * (corners[i] - corners[0]));
}

}  // namespace isolux::testing
