#include "tests/support/surface_points.h"

#include <algorithm>
#include <cmath>

#include "common/hierarchy/element.h"
#include "common/util/random.h"
#include "worker/radiosity/polygon_sampler.h"

namespace isolux::testing {
namespace {

constexpr int kSpeckLevel = 30;
constexpr double kNearby = 1e-4;  // of the scene's extent: how far a point may be off its surface

double DistanceOutside(const ConvexPolygon& polygon, const Vec3& n, const Vec3& x) {
  double outside = std::abs(glm::dot(n, x - polygon.v[0]));
  for (int i = 0; i < polygon.count; ++i) {
    const Vec3 side = polygon.v[(i + 1) % polygon.count] - polygon.v[i];
    outside =
        std::max(outside, -glm::dot(glm::cross(n, side), x - polygon.v[i]) / glm::length(side));
  }
  return outside;
}

NodeId SpeckAt(const Hierarchy& hierarchy, uint32_t surface, const Vec3& x) {
  NodeId id{surface, 1};
  ConvexPolygon polygon = hierarchy.geometry(surface);
  const Vec3 n = polygon.Normal();
  while (id.level() < kSpeckLevel) {
    const auto parts = Subdivide(polygon);
    const int k = DistanceOutside(parts[0], n, x) <= DistanceOutside(parts[1], n, x) ? 0 : 1;
    id = id.Child(k);
    polygon = parts[k];
  }
  return id;
}

void SortByElement(std::vector<PointOnSurface>* points) {
  std::sort(points->begin(), points->end(),
            [](const PointOnSurface& a, const PointOnSurface& b) { return a.element < b.element; });
}

}  // namespace

std::vector<PointOnSurface> UniformPoints(const Hierarchy& hierarchy, uint64_t count,
                                          uint64_t seed) {
  const Scene& scene = hierarchy.scene();
  double area = 0;
  for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) area += hierarchy.surface_area_m2(s);
  std::vector<PointOnSurface> points(count);
  uint32_t surface = 0;
  double area_up_to = hierarchy.surface_area_m2(0);
  for (uint64_t i = 0; i < count; ++i) {
    Random random(Hash(seed, i));
    const double place =
        (static_cast<double>(i) + random.Unit()) * (area / static_cast<double>(count));
    while (surface + 1 < hierarchy.surfaces().size() && area_up_to <= place) {
      area_up_to += hierarchy.surface_area_m2(++surface);
    }
    const double u = random.Unit();
    const Vec3 x = SamplePolygon(hierarchy.geometry(surface), u, random.Unit());
    points[i].element = SpeckAt(hierarchy, surface, x);
    points[i].position_m = x;
    points[i].expected.position = (x + scene.origin_m) / scene.metres_per_unit;
    points[i].expected.normal = hierarchy.geometry(surface).Normal();
  }
  SortByElement(&points);
  return points;
}

std::vector<PointOnSurface> PlacePoints(const Hierarchy& hierarchy,
                                        std::span<const ReferencePoint> points) {
  const Scene& scene = hierarchy.scene();
  std::vector<PointOnSurface> placed;
  for (const ReferencePoint& point : points) {
    const Vec3 x = point.position * scene.metres_per_unit - scene.origin_m;
    double best = kNearby * hierarchy.extent_m();
    uint32_t surface = 0xffffffffu;
    for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) {
      const ConvexPolygon& polygon = hierarchy.geometry(s);
      const Vec3 normal = polygon.Normal();
      if (glm::dot(normal, point.normal) < 0.999) continue;
      const double outside = DistanceOutside(polygon, normal, x);
      if (outside >= best) continue;
      best = outside;
      surface = s;
    }
    if (surface == 0xffffffffu) continue;
    placed.push_back({SpeckAt(hierarchy, surface, x), x, point});
  }
  SortByElement(&placed);
  return placed;
}

std::vector<NodeId> ElementsOf(std::span<const PointOnSurface> points) {
  std::vector<NodeId> elements;
  elements.reserve(points.size());
  for (const PointOnSurface& point : points) elements.push_back(point.element);
  return elements;
}

Rgb IrradianceOf(const GatherPart& part, size_t i) {
  Rgb h(0.0);
  for (int c = 0; c < 3; ++c) {
    h[c] = std::ldexp(static_cast<double>(std::max<int64_t>(0, part.sums[12 * i + c])),
                      -part.exponent);
  }
  return h;
}

}  // namespace isolux::testing
