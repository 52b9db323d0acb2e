#include "worker/radiosity/polygon_seen.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/coupling/lanes.h"

namespace isolux {
namespace {

// Solid angle of a triangle seen from the origin ([VanOosteromStrackee83]), signed.
double SolidAngle(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
  const double volume = glm::dot(a, glm::cross(b, c));
  const double sum = la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb;
  const double angle = 2 * Atan2Upper(Splat(std::abs(volume)), Splat(sum))[0];
  return volume < 0 ? -angle : angle;
}

}  // namespace

double SolidAngle(const ConvexPolygon& polygon, const Vec3& from) {
  double angle = 0;
  for (int i = 1; i + 1 < polygon.count; ++i) {
    angle += SolidAngle(polygon.v[0] - from, polygon.v[i] - from, polygon.v[i + 1] - from);
  }
  return std::abs(angle);
}

Vec3 NearestInside(const ConvexPolygon& polygon, const Vec3& normal, const Vec3& point) {
  bool inside = true;
  Vec3 nearest = polygon.v[0];
  double least2 = std::numeric_limits<double>::infinity();
  for (int i = 0; i < polygon.count; ++i) {
    const Vec3& a = polygon.v[i];
    const Vec3 along = polygon.v[(i + 1) % polygon.count] - a;
    inside &= glm::dot(glm::cross(along, point - a), normal) >= 0;
    const double t = glm::dot(point - a, along) / std::max(glm::dot(along, along), 1e-300);
    const Vec3 candidate = a + std::clamp(t, 0.0, 1.0) * along;
    const double distance2 = glm::dot(candidate - point, candidate - point);
    if (distance2 < least2) {
      least2 = distance2;
      nearest = candidate;
    }
  }
  return inside ? point : nearest;
}

}  // namespace isolux
