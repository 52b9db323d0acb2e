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
