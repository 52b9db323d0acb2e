#include <algorithm>
#include <cmath>

#include "common/scene/scene.h"
#include "common/scene/surface_maps.h"

namespace isolux {

Vec3 ConvexPolygon::AreaVector() const {
  // Newell's sum about the first corner, so that distance from the origin does not cancel.
  Vec3 sum(0.0);
  for (int i = 1; i + 1 < count; ++i) sum += glm::cross(v[i] - v[0], v[i + 1] - v[0]);
  return 0.5 * sum;
}

Vec3 ConvexPolygon::Centroid() const {
  const Vec3 normal = AreaVector();
  Vec3 moment(0.0);
  double weight = 0;
  for (int i = 1; i + 1 < count; ++i) {
    const double area = glm::dot(glm::cross(v[i] - v[0], v[i + 1] - v[0]), normal);
    moment += area * (v[i] - v[0] + v[i + 1] - v[0]);
    weight += area;
  }
  return weight > 0 ? v[0] + moment / (3.0 * weight) : v[0];
}

bool HasArea(const ConvexPolygon& polygon) {
  double longest2 = 0;
  for (int i = 0; i < polygon.count; ++i) {
    const Vec3 side = polygon.v[(i + 1) % polygon.count] - polygon.v[i];
    longest2 = std::max(longest2, glm::dot(side, side));
  }
  const double area = polygon.Area();
  return area > kNoArea * longest2 && area > 1e-200;
}

bool IsPlanar(const ConvexPolygon& polygon) {
  if (polygon.count < 4) return true;
  const Vec3 normal = polygon.Normal();
  const double diagonal =
      std::max(glm::length(polygon.v[2] - polygon.v[0]), glm::length(polygon.v[3] - polygon.v[1]));
  // The normal is that of both diagonals, so the corners lie alternately above and below the plane.
  const double gap = std::abs(glm::dot(polygon.v[1] - polygon.v[0], normal));
  return gap <= kPlanarTolerance * diagonal;
}

bool IsConvex(const ConvexPolygon& polygon) {
  const Vec3 normal = polygon.Normal();
  for (int i = 0; i < polygon.count; ++i) {
    const Vec3& here = polygon.v[i];
    const Vec3 in = here - polygon.v[(i + polygon.count - 1) % polygon.count];
    const Vec3 out = polygon.v[(i + 1) % polygon.count] - here;
    const double turn = glm::dot(glm::cross(in, out), normal);
    if (turn < -kConvexTolerance * glm::length(in) * glm::length(out)) return false;
  }
  return true;
}

ConvexPolygon SideGeometry(const Scene& scene, uint32_t polygon, Side side) {
  const Polygon& source = scene.polygons[polygon];
  ConvexPolygon result;
  result.count = source.vertex_count();
  for (int i = 0; i < result.count; ++i) {
    const int from = side == Side::kFront ? i : result.count - 1 - i;
    result.v[i] = scene.vertices[source.vertices[from]];
  }
  return result;
}

std::vector<Surface> MakeSurfaces(const Scene& scene) {
  std::vector<Surface> surfaces;
  for (uint32_t p = 0; p < scene.polygons.size(); ++p) {
    const Polygon& polygon = scene.polygons[p];
    const Material& material = scene.materials[polygon.material];
    const auto add = [&](Side side, uint8_t takes_part, uint8_t emits) {
      if ((polygon.sides & (takes_part | emits)) == 0) return;
      surfaces.push_back({p, side,
                          (polygon.sides & takes_part) != 0 ? material.reflectance : Rgb(0.0),
                          (polygon.sides & emits) != 0 ? material.exitance : Rgb(0.0)});
    };
    add(Side::kFront, kFrontTakesPart, kFrontEmits);
    add(Side::kBack, kBackTakesPart, kBackEmits);
  }
  if (scene.textures.empty()) return surfaces;
  const SurfaceMaps maps(scene);
  for (Surface& surface : surfaces) {
    const Optics optics = maps.Over(surface, SideGeometry(scene, surface.polygon, Side::kFront));
    surface.reflectance = optics.reflectance;
    surface.exitance = optics.exitance;
  }
  return surfaces;
}

ConvexPolygon ShapeOf(const Pane& pane) {
  ConvexPolygon shape;
  shape.count = static_cast<int>(pane.count);
  shape.v = pane.corners;
  return shape;
}

ConvexPolygon ShapeOf(const Scene& scene, uint32_t number) {
  if (number < scene.polygons.size()) return SideGeometry(scene, number, Side::kFront);
  return ShapeOf(scene.glazing.panes[number - scene.polygons.size()]);
}

}  // namespace isolux
