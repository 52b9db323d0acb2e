#include "common/hierarchy/effects/scene_rays.h"

#include <cmath>

#include "common/util/angles.h"

namespace isolux {
namespace {

// Distance at which the ray meets the polygon, infinite where it does not.
double Meets(const SceneRay& ray, const ConvexPolygon& polygon, const Vec3& normal) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const double falls = glm::dot(normal, ray.direction);
  if (falls == 0) return kNever;
  const double t = glm::dot(normal, polygon.v[0] - ray.from) / falls;
  if (!(t > 0)) return kNever;
  const Vec3 point = ray.from + t * ray.direction;
  for (int i = 0; i < polygon.count; ++i) {
    const Vec3 along = polygon.v[(i + 1) % polygon.count] - polygon.v[i];
    if (glm::dot(glm::cross(along, point - polygon.v[i]), normal) < 0) return kNever;
  }
  return t;
}

}  // namespace

SceneRay RayFrom(const Hierarchy& hierarchy, uint32_t surface, Random& random) {
  const ConvexPolygon& p = hierarchy.geometry(surface);
  const double first = glm::length(glm::cross(p.v[1] - p.v[0], p.v[2] - p.v[0]));
  const double second =
      p.count == 4 ? glm::length(glm::cross(p.v[2] - p.v[0], p.v[3] - p.v[0])) : 0.0;
  const int k = random.Unit() * (first + second) < first ? 1 : 2;
  const double root = std::sqrt(random.Unit()), v = random.Unit();
  SceneRay ray;
  ray.from = p.v[0] + root * ((1 - v) * (p.v[k] - p.v[0]) + v * (p.v[k + 1] - p.v[0]));
  const Vec3 n = p.Normal();
  const Vec3 side =
      glm::normalize(glm::cross(n, std::abs(n.x) < 0.5 ? Vec3(1, 0, 0) : Vec3(0, 1, 0)));
  const double a = 2 * random.Unit() - 1;
  const auto [x, y] = SquareToDisk(a, 2 * random.Unit() - 1);
  ray.direction =
      x * side + y * glm::cross(n, side) + std::sqrt(std::max(1e-12, 1 - x * x - y * y)) * n;
  ray.polygon = hierarchy.surfaces()[surface].polygon;
  return ray;
}

SceneRays::SceneRays(const Hierarchy& hierarchy) : hierarchy_(hierarchy) {
  const Scene& scene = hierarchy.scene();
  for (uint32_t p = 0; p < scene.polygons.size(); ++p) {
    shapes_.push_back(SideGeometry(scene, p, Side::kFront));
    normals_.push_back(shapes_.back().Normal());
  }
}

SceneRays::Met SceneRays::Meet(const SceneRay& ray) const {
  Met met;
  met.distance = std::numeric_limits<double>::infinity();
  for (uint32_t p = 0; p < shapes_.size(); ++p) {
    if (hierarchy_.plane_of(p) == hierarchy_.plane_of(ray.polygon)) continue;
    const bool front = glm::dot(normals_[p], ray.direction) < 0;
    const uint8_t sides = hierarchy_.scene().polygons[p].sides;
    if ((sides & (front ? kFrontCovered : kBackCovered)) != 0) continue;
    const double t = Meets(ray, shapes_[p], normals_[p]);
    if (!(t < met.distance)) continue;
    const int takes_part = front ? kFrontTakesPart | kFrontEmits : kBackTakesPart | kBackEmits;
    met = {p, front ? Side::kFront : Side::kBack, (sides & takes_part) != 0, t};
  }
  return met;
}

}  // namespace isolux
